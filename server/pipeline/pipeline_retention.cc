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
      list.push_back({id, record.robot, record.state == SessionState::kFinished, record.created_ns,
                      record.finished_ns, 0, 0});
    }
    return list;
  };
  hooks.map_bytes = [this](const SessionId& session) { return store_->StoredBytes(session); };
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
