// What the limits on the robots' sessions rest on, and what they lead to.
#include "server/pipeline/pipeline_impl.h"

namespace isthmus::server {

RetentionLoop::Hooks PipelineImpl::RetentionHooks() {
  RetentionLoop::Hooks hooks;
  hooks.list = [this] {
    std::vector<StoredSession> list;
    std::lock_guard lock(state_.mutex);
    for (const auto& [id, entry] : state_.sessions) {
      const SessionRecord& record = entry.record;
      if (record.segment > 1) continue;  // Counted, and gone, with the first.
      list.push_back({id, record.robot, record.state == SessionState::kFinished, record.created_ns,
                      record.finished_ns, 0, 0});
    }
    return list;
  };
  hooks.map_bytes = [this](const SessionId& session) -> absl::StatusOr<uint64_t> {
    std::vector<SessionId> segments;
    {
      std::lock_guard lock(state_.mutex);
      for (const SessionEntry* entry : state_.SegmentsOf(session)) {
        segments.push_back(entry->record.id);
      }
    }
    uint64_t total = 0;
    for (const SessionId& segment : segments) {
      const absl::StatusOr<uint64_t> bytes = store_->StoredBytes(segment);
      if (!bytes.ok()) return bytes.status();
      total += *bytes;
    }
    return total;
  };
  hooks.scan_bytes = [this](const SessionId& session) { return scans_->Bytes(session); };
  hooks.act = [this](const RetentionAction& action) {
    if (action.kind == RetentionAction::Kind::kDropScans) {
      return scans_->Free(action.session, action.bytes);
    }
    return Delete(action.session, action.why);
  };
  hooks.on_problem = options_.on_problem;
  return hooks;
}

}  // namespace isthmus::server
