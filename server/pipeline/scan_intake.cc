// The intake of sessions: scans, and submaps of robots with their own SLAM.
#include <absl/cleanup/cleanup.h>
#include <absl/strings/str_cat.h>

#include <utility>

#include "core/concurrency/mutex.h"
#include "server/ingest/uploaded_submap.h"
#include "server/pipeline/session_manager.h"

namespace isthmus::server {

absl::StatusOr<SessionManager::Worker> SessionManager::FindWorker(const SessionId& session) const {
  const MapWriter::View view = parts_.map.view();
  const auto opened = FindOpened(*view, session);
  if (!opened.ok()) return opened.status();
  const SessionRecord& record = (*opened)->record;
  ingest::SessionWorkers::Entry entry = parts_.workers.Find(session);
  if (record.state != SessionState::kFinished && entry.worker == nullptr) {
    return absl::FailedPreconditionError(absl::StrCat(
        "session ", session.value(), " could not be taken up after the server's start, see its ",
        "log: create a new session for robot ", record.robot.value()));
  }
  if (entry.worker == nullptr) {
    return absl::FailedPreconditionError(
        absl::StrCat("session ", session.value(), " is finished: create a new session for robot ",
                     record.robot.value()));
  }
  if (entry.uploads) {
    return absl::FailedPreconditionError(
        absl::StrCat("session ", session.value(),
                     " holds uploaded submaps: create another session to stream scans"));
  }
  return std::move(entry.worker);
}

absl::Status SessionManager::SetAckSink(const SessionId& session, AckSink sink) {
  if (absl::Status status = parts_.check_takes_changes(); !status.ok()) return status;
  Worker worker;
  if (sink) {
    auto found = FindWorker(session);
    if (!found.ok()) return found.status();
    worker = *std::move(found);
  } else {
    // Taking a sink away always works, so that a stream can end after its session did.
    worker = parts_.workers.Find(session).worker;
  }
  if (worker != nullptr) worker->SetAckSink(std::move(sink));
  return absl::OkStatus();
}

absl::StatusOr<bool> SessionManager::AdmitScan(const SessionId& session, ScanUpload* scan,
                                               bool waits) {
  if (absl::Status status = parts_.check_takes_changes(); !status.ok()) return status;
  if (parts_.shut_down) return absl::UnavailableError("the server is shutting down");
  auto worker = FindWorker(session);
  if (!worker.ok()) return worker.status();
  if (absl::Status status = parts_.retention->CheckQuota((*worker)->robot()); !status.ok()) {
    return status;
  }
  absl::Status kept = parts_.scans->RecordScan(session, (*worker)->last_sequence(), *scan);
  if (!kept.ok()) return kept;
  parts_.activity.ScanQueued();
  absl::Cleanup not_queued = [this] { parts_.activity.ScanDone(); };
  const absl::StatusOr<bool> taken = (*worker)->Admit(scan, waits);
  if (taken.value_or(false)) std::move(not_queued).Cancel();
  return taken;
}

absl::Status SessionManager::CheckUpload(const SessionView& session, const SubmapId& submap) const {
  if (session.record.state == SessionState::kFinished) {
    return absl::FailedPreconditionError(
        absl::StrCat("session ", submap.session.value(), " is finished: create a new one"));
  }
  const ingest::SessionWorkers::Entry entry = parts_.workers.Find(submap.session);
  if (entry.worker != nullptr && entry.worker->last_sequence() > 0 && !entry.uploads) {
    return absl::FailedPreconditionError(
        absl::StrCat("session ", submap.session.value(),
                     " has scans: create another session to upload submaps"));
  }
  if (submap.index > session.next_index()) {
    return absl::OutOfRangeError(absl::StrCat("submap index ", submap.index, " leaves a gap: ",
                                              session.next_index(), " is expected next"));
  }
  return absl::OkStatus();
}

absl::StatusOr<SubmapInfo> SessionManager::RepeatUpload(const SubmapInfo* existing,
                                                        const Submap& repeated) {
  // It took effect, and newer submaps of the place took its place.
  if (existing == nullptr) return Summarize(repeated);
  const auto stored = parts_.submaps.TryGet(existing->id);
  if (absl::IsUnavailable(stored.status())) return stored.status();
  if (!stored.ok()) {
    return absl::DataLossError(
        absl::StrCat("submap ", ToString(existing->id), " is stored but cannot be read any more"));
  }
  if (ingest::SameSubmap(**stored, repeated)) return *existing;
  return absl::AlreadyExistsError(
      absl::StrCat("submap ", ToString(existing->id), " exists with other content"));
}

absl::StatusOr<SubmapInfo> SessionManager::AddSubmap(Submap submap) {
  if (absl::Status status = parts_.check_takes_changes(); !status.ok()) return status;
  if (parts_.shut_down) return absl::UnavailableError("the server is shutting down");
  ++parts_.submaps_coming_in;
  const absl::Cleanup came_in = [this] { --parts_.submaps_coming_in; };
  // Large submaps take seconds: only their own session waits.
  MutexLock uploading(&parts_.UploadsOf(submap.id.session));
  const MapWriter::View view = parts_.map.view();
  const SubmapId id = submap.id;
  const auto opened = FindOpened(*view, id.session);
  if (!opened.ok()) return opened.status();
  const SessionView& session = **opened;
  if (absl::Status status = CheckUpload(session, id); !status.ok()) return status;
  submap.robot = session.record.robot;
  absl::StatusOr<FinishedSubmap> finished = ingest::MakeUploadedSubmap(std::move(submap));
  if (!finished.ok()) return finished.status();
  if (id.index < session.next_index()) {
    return RepeatUpload(session.submaps.Find(id.index), *finished->submap);
  }
  absl::Status may_add = parts_.retention->CheckQuota(session.record.robot);
  if (!may_add.ok()) return may_add;
  {
    const StageTimer timer(parts_.options.observer, Stage::kStore);
    absl::Status status = parts_.map.AddSubmap(id.session, *finished);
    if (!status.ok()) return status;
  }
  parts_.retention->NoteChange(id.session);
  parts_.workers.NoteUploads(id.session);
  return Summarize(*finished->submap);
}

}  // namespace isthmus::server
