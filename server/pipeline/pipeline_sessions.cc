// Sessions and what comes in through them.
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <tuple>
#include <utility>

#include "floam/odometry_mode.h"
#include "floam/rings/sensor_model.h"
#include "server/pipeline/pipeline_impl.h"
#include "server/pipeline/uploaded_submap.h"

namespace isthmus::server {
namespace {

constexpr size_t kMaxRobotName = 64, kMaxRequestId = 64;

absl::Status CheckRobotName(const RobotId& robot) {
  const std::string& name = robot.value();
  const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '.' || c == '-';
  });
  if (name.empty() || name.size() > kMaxRobotName || !plain) {
    return absl::InvalidArgumentError(
        absl::StrCat("robot name \"", name, "\" cannot be used: give 1 to ", kMaxRobotName,
                     " characters of letters, digits, '_', '.' and '-'"));
  }
  return absl::OkStatus();
}

absl::Status UnknownSession(const SessionId& session) {
  return absl::NotFoundError(absl::StrCat("no session \"", session.value(),
                                          "\": create one, or list the sessions there are"));
}

}  // namespace

absl::StatusOr<SessionStatus> PipelineImpl::CreateSession(const SessionRequest& request) {
  if (shut_down_) return absl::UnavailableError("the server is shutting down");
  if (absl::Status status = CheckRobotName(request.robot); !status.ok()) return status;
  if (!request.T_base_sensor.IsFinite()) {
    return absl::InvalidArgumentError("T_base_sensor has numbers that are not finite");
  }
  if (request.request_id.size() > kMaxRequestId) {
    return absl::InvalidArgumentError(
        absl::StrCat("a request id has at most ", kMaxRequestId, " characters"));
  }
  SessionRecord record;
  record.robot = request.robot;
  record.sensor = request.sensor;
  record.odometry = request.odometry;
  record.T_base_sensor = request.T_base_sensor;
  record.created_ns = clock_.NowNs();
  record.request_id = request.request_id;
  std::lock_guard changing(membership_mutex_);
  if (const auto opened = FindRequested(record); opened.has_value()) return *opened;
  if (absl::Status status = retention_->Check(request.robot); !status.ok()) return status;
  const auto numbered = last_numbers_.find(record.robot);
  int number = numbered == last_numbers_.end() ? 0 : numbered->second;
  {
    std::lock_guard lock(state_.mutex);
    do {
      record.id = SessionId(absl::StrCat(record.robot.value(), "-", ++number));
    } while (state_.Find(record.id) != nullptr || scans_->Bytes(record.id) > 0);
  }
  auto worker = MakeWorker(record, {});
  if (!worker.ok()) return worker.status();
  storage::WriteBatch batch;
  batch.sessions.push_back(record);
  if (absl::Status status = store_->Write(batch); !status.ok()) return status;
  last_numbers_[record.robot] = number;
  std::lock_guard lock(state_.mutex);
  SessionEntry& entry = state_.sessions[record.id];
  entry.record = record;
  entry.worker = *std::move(worker);
  return StatusOf(entry);
}

std::optional<SessionStatus> PipelineImpl::FindRequested(const SessionRecord& record) {
  if (record.request_id.empty()) return std::nullopt;
  std::lock_guard lock(state_.mutex);
  for (const auto& [id, entry] : state_.sessions) {
    const bool same =
        entry.record.robot == record.robot && entry.record.request_id == record.request_id;
    if (same) return StatusOf(entry);
  }
  return std::nullopt;
}

absl::StatusOr<std::shared_ptr<ingest::SessionWorker>> PipelineImpl::MakeWorker(
    const SessionRecord& record, const ingest::ResumePoint& resume) {
  absl::StatusOr<floam::SensorModel> sensor = floam::FindSensorModel(record.sensor);
  if (!sensor.ok()) {
    return absl::InvalidArgumentError(sensor.status().message());
  }
  ingest::SessionWorker::Options options{options_.scan_queue, options_.odometry, options_.submap};
  if (!record.odometry.empty()) {
    absl::StatusOr<floam::OdometryMode> mode = floam::FindOdometryMode(record.odometry);
    if (!mode.ok()) return mode.status();
    options.odometry.mode = *mode;
  }
  ingest::WorkerHooks hooks;
  hooks.persist = [this, id = record.id](const ingest::Stretch& stretch) {
    if (absl::Status kept = scans_->Sync(id); !kept.ok()) return kept;
    absl::Status stored = state_.AddStretch(id, stretch);
    if (stored.ok()) retention_->Changed(id);
    return stored;
  };
  hooks.T_map_odom = [this, id = record.id](uint32_t segment) -> std::optional<Pose> {
    std::lock_guard lock(state_.mutex);
    const Placement* placement = state_.PlacementOf(SegmentId(id, segment));
    if (placement == nullptr) return std::nullopt;
    return placement->T_map_odom;
  };
  hooks.scan_done = [this] { state_.ScanDone(); };
  hooks.tell = options_.on_event;
  return ingest::SessionWorker::Create(record, *sensor, options, std::move(hooks), executor_.get(),
                                       resume);
}

absl::StatusOr<SessionStatus> PipelineImpl::GetSession(const SessionId& session) {
  std::lock_guard lock(state_.mutex);
  const SessionEntry* entry = state_.Find(session);
  if (entry == nullptr) return UnknownSession(session);
  return StatusOf(*entry);
}

std::vector<SessionStatus> PipelineImpl::ListSessions() {
  std::vector<SessionStatus> list;
  std::lock_guard lock(state_.mutex);
  for (const auto& [id, entry] : state_.sessions) list.push_back(StatusOf(entry));
  std::map<SessionId, int64_t> opened_ns;
  for (const SessionStatus& status : list) {
    if (status.record.segment == 1) opened_ns[status.record.id] = status.record.created_ns;
  }
  const auto place = [&](const SessionStatus& status) {
    const SessionId& opened = status.record.opened();
    return std::tuple(opened_ns[opened], opened, status.record.segment);
  };
  std::sort(list.begin(), list.end(),
            [&](const auto& a, const auto& b) { return place(a) < place(b); });
  return list;
}

absl::StatusOr<SessionEntry*> PipelineImpl::FindOpened(const SessionId& session) {
  SessionEntry* entry = state_.Find(session);
  if (entry == nullptr) return UnknownSession(session);
  if (entry->record.segment == 1) return entry;
  const std::string& opened = entry->record.first_segment.value();
  return absl::FailedPreconditionError(
      absl::StrCat(session.value(), " is segment ", entry->record.segment, " of session ", opened,
                   ", which its robot streams to and which is finished and deleted as a whole: "
                   "name ",
                   opened));
}

absl::StatusOr<SessionStatus> PipelineImpl::FinishSession(const SessionId& session) {
  std::shared_ptr<ingest::SessionWorker> worker;
  {
    std::lock_guard lock(state_.mutex);
    const absl::StatusOr<SessionEntry*> entry = FindOpened(session);
    if (!entry.ok()) return entry.status();
    if ((*entry)->record.state == SessionState::kFinished) return StatusOf(**entry);
    worker = (*entry)->worker;
  }
  if (absl::Status status = scans_->Finish(session); !status.ok()) return status;
  if (worker != nullptr) {
    if (absl::Status status = worker->Finish(); !status.ok()) return status;
  }
  std::lock_guard changing(membership_mutex_);
  storage::WriteBatch batch;
  {
    std::lock_guard lock(state_.mutex);
    for (const SessionEntry* segment : state_.SegmentsOf(session)) {
      batch.sessions.push_back(segment->record);
    }
  }
  if (batch.sessions.empty()) return UnknownSession(session);
  if (worker != nullptr) batch.sessions.front().scans = worker->Status().scans;
  const int64_t now_ns = clock_.NowNs();
  for (SessionRecord& record : batch.sessions) {
    record.state = SessionState::kFinished;
    record.finished_ns = now_ns;
  }
  if (absl::Status status = store_->Write(batch); !status.ok()) return status;
  // No ack follows the last one, and whoever took them may be gone before the worker is.
  if (worker != nullptr) worker->SetAckSink(nullptr);
  std::lock_guard lock(state_.mutex);
  for (const SessionRecord& record : batch.sessions) state_.sessions[record.id].record = record;
  SessionEntry* entry = state_.Find(session);
  if (entry->worker != nullptr) {
    entry->final_status = entry->worker->Status();
    entry->worker = nullptr;
  }
  retention_->Changed(session);
  state_.changed.notify_all();
  return StatusOf(*entry);
}

absl::Status PipelineImpl::DeleteSession(const SessionId& session) {
  absl::Status status = Delete(session, "");
  if (status.ok()) retention_->Changed(session);
  return status;
}

// Its scans go first: what is left if that stops half way is a session without.
absl::Status PipelineImpl::Delete(const SessionId& session, const std::string& why) {
  std::shared_ptr<ingest::SessionWorker> worker;
  {
    std::lock_guard lock(state_.mutex);
    const absl::StatusOr<SessionEntry*> entry = FindOpened(session);
    if (!entry.ok()) return entry.status();
    worker = (*entry)->worker;
  }
  if (worker != nullptr) worker->Abandon();
  std::lock_guard changing(membership_mutex_);
  if (absl::Status status = scans_->Remove(session); !status.ok()) return status;
  if (absl::Status status = state_.RemoveSession(session, why); !status.ok()) return status;
  state_.WaitUntilPlaced();
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<ingest::SessionWorker>> PipelineImpl::FindWorker(
    const SessionId& session) {
  std::lock_guard lock(state_.mutex);
  const absl::StatusOr<SessionEntry*> found = FindOpened(session);
  if (!found.ok()) return found.status();
  const SessionEntry* entry = *found;
  if (entry->record.state == SessionState::kFinished || entry->worker == nullptr) {
    return absl::FailedPreconditionError(
        absl::StrCat("session ", session.value(), " is finished: create a new session for robot ",
                     entry->record.robot.value()));
  }
  if (entry->uploads) {
    return absl::FailedPreconditionError(
        absl::StrCat("session ", session.value(),
                     " holds uploaded submaps: create another session to stream scans"));
  }
  return entry->worker;
}

absl::Status PipelineImpl::SetAckSink(const SessionId& session, AckSink sink) {
  std::shared_ptr<ingest::SessionWorker> worker;
  if (sink) {
    auto found = FindWorker(session);
    if (!found.ok()) return found.status();
    worker = *std::move(found);
  } else {
    // Taking a sink away always works, so that a stream can end after its session did.
    std::lock_guard lock(state_.mutex);
    if (const SessionEntry* entry = state_.Find(session)) worker = entry->worker;
  }
  // Not under the state's lock: this waits for an ack that is being sent.
  if (worker != nullptr) worker->SetAckSink(std::move(sink));
  return absl::OkStatus();
}

absl::Status PipelineImpl::SubmitScan(const SessionId& session, ScanUpload scan) {
  if (shut_down_) return absl::UnavailableError("the server is shutting down");
  auto worker = FindWorker(session);
  if (!worker.ok()) return worker.status();
  if (absl::Status status = retention_->Check((*worker)->robot()); !status.ok()) return status;
  absl::Status kept = scans_->Keep(session, (*worker)->last_sequence(), scan);
  if (!kept.ok()) return kept;
  state_.ScanQueued();
  absl::Status status = (*worker)->Submit(std::move(scan));
  if (!status.ok()) state_.ScanDone();
  return status;
}

absl::StatusOr<SubmapInfo> PipelineImpl::AddSubmap(Submap submap) {
  if (shut_down_) return absl::UnavailableError("the server is shutting down");
  std::lock_guard changing(membership_mutex_);
  std::shared_ptr<const SubmapInfo> existing;
  bool was_retired = false;
  {
    std::lock_guard lock(state_.mutex);
    const absl::StatusOr<SessionEntry*> found = FindOpened(submap.id.session);
    if (!found.ok()) return found.status();
    const SessionEntry* entry = *found;
    if (entry->record.state == SessionState::kFinished) {
      return absl::FailedPreconditionError(
          absl::StrCat("session ", submap.id.session.value(), " is finished: create a new one"));
    }
    if (entry->worker->last_sequence() > 0 && !entry->uploads) {
      return absl::FailedPreconditionError(
          absl::StrCat("session ", submap.id.session.value(),
                       " has scans: create another session to upload submaps"));
    }
    if (submap.id.index < entry->next_index()) {
      existing = entry->FindSubmap(submap.id.index);
      was_retired = existing == nullptr;
    } else if (submap.id.index > entry->next_index()) {
      return absl::OutOfRangeError(absl::StrCat("submap index ", submap.id.index, " leaves a gap: ",
                                                entry->next_index(), " is expected next"));
    }
    submap.robot = entry->record.robot;
  }
  absl::StatusOr<ingest::Stretch> stretch = MakeUploadedStretch(std::move(submap));
  if (!stretch.ok()) return stretch.status();
  if (existing != nullptr) {
    const std::shared_ptr<const Submap> stored = submaps_.Get(existing->id);
    if (stored == nullptr) {
      return absl::DataLossError(absl::StrCat("submap ", ToString(existing->id),
                                              " is stored but cannot be read any more"));
    }
    if (SameSubmap(*stored, *stretch->submap)) return *existing;
    return absl::AlreadyExistsError(
        absl::StrCat("submap ", ToString(existing->id), " exists with other content"));
  }
  // It took effect, and newer submaps of the place took its place.
  if (was_retired) return Summarize(*stretch->submap);
  const SessionId session = stretch->submap->id.session;
  absl::Status may_add = retention_->Check(stretch->submap->robot);
  if (!may_add.ok()) return may_add;
  if (absl::Status status = state_.AddStretch(session, *stretch); !status.ok()) return status;
  retention_->Changed(session);
  std::lock_guard lock(state_.mutex);
  if (SessionEntry* entry = state_.Find(session)) entry->uploads = true;
  return Summarize(*stretch->submap);
}

}  // namespace isthmus::server
