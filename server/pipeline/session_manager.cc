#include "server/pipeline/session_manager.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/strip.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "core/concurrency/mutex.h"
#include "core/plain_text.h"
#include "floam/rings/sensor_model.h"
#include "server/map/edit_events.h"

namespace isthmus::server {
namespace {

constexpr size_t kMaxRobotName = 64;
// Time for which an open session without data is left alone. A robot sends its first scan within
// seconds of opening one.
constexpr int64_t kEmptyForNs = 60'000'000'000;
// The largest number in an id that this program has not given out.
constexpr int kMaxNumber = 1'000'000'000;

absl::Status CheckRequest(const SessionRequest& request) {
  if (absl::Status status = CheckRobotName(request.robot); !status.ok()) return status;
  if (!request.T_base_sensor.IsFinite()) {
    return absl::InvalidArgumentError("T_base_sensor has numbers that are not finite");
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status CheckRobotName(const RobotId& robot) {
  const std::string& name = robot.value();
  const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '.' || c == '-';
  });
  if (name.empty() || name.size() > kMaxRobotName || !plain) {
    return absl::InvalidArgumentError(
        absl::StrCat("robot name \"", LineOf(name, kMaxRobotName), "\" cannot be used: give 1 to ",
                     kMaxRobotName, " characters of letters, digits, '_', '.' and '-'"));
  }
  return absl::OkStatus();
}

absl::Status UnknownSession(const SessionId& session) {
  return absl::NotFoundError(absl::StrCat("no session \"", session.value(),
                                          "\": create one, or list the sessions there are"));
}

absl::StatusOr<const SessionView*> FindOpened(const MapView& view, const SessionId& session) {
  const SessionView* known = view.Find(session);
  if (known == nullptr) return UnknownSession(session);
  if (known->record.segment == 1) return known;
  const std::string& opened = known->record.first_segment.value();
  return absl::FailedPreconditionError(
      absl::StrCat(session.value(), " is segment ", known->record.segment, " of session ", opened,
                   ", which its robot streams to and which is finished and deleted as a whole: "
                   "name ",
                   opened));
}

absl::StatusOr<SessionStatus> SessionManager::Create(const SessionRequest& request,
                                                     const Actor& by) {
  if (absl::Status status = parts_.check_takes_changes(); !status.ok()) return status;
  if (parts_.shut_down) return absl::UnavailableError("the server is shutting down");
  if (absl::Status status = CheckRequest(request); !status.ok()) return status;
  const auto sensor = floam::FindSensorModel(request.sensor);
  if (!sensor.ok()) return absl::InvalidArgumentError(sensor.status().message());
  SessionRecord record{request};
  record.sensor = sensor->name;  // Not as it was spelt: the stored name is listed to everybody.
  record.created_ns = parts_.clock.NowNs();
  MakeRoom();
  MutexLock changing(&parts_.membership);
  if (const auto opened = FindRequested(record); opened.has_value()) return *opened;
  if (absl::Status status = CheckOpenSessions(request.robot); !status.ok()) return status;
  if (absl::Status status = parts_.retention->CheckQuota(request.robot); !status.ok())
    return status;
  const auto numbered = last_numbers_.find(record.robot);
  int number = numbered == last_numbers_.end() ? 0 : numbered->second;
  record.id = NextId(record.robot, &number);
  auto worker = MakeWorker(record, {});
  if (!worker.ok()) return worker.status();
  const Event event = SessionEvent(EventKind::kSessionOpened, record, by);
  if (auto status = parts_.map.PutSessions({record}, event); !status.ok()) return status;
  last_numbers_[record.robot] = number;
  parts_.workers.Add(record.id, *std::move(worker));
  return Get(record.id);
}

absl::Status SessionManager::CheckOpenSessions(const RobotId& robot) const {
  const MapWriter::View view = parts_.map.view();
  size_t all = 0, own = 0;
  for (const auto& [id, session] : view->sessions) {
    if (session.record.segment > 1 || session.record.state == SessionState::kFinished) continue;
    ++all;
    own += session.record.robot == robot ? 1 : 0;
  }
  if (own >= parts_.options.max_open_sessions_per_robot) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "robot ", robot.value(), " has ", own,
        " open sessions, as many as it may: finish those it ",
        "does not use (isthmus session finish), or raise ingest.max_open_sessions_per_robot"));
  }
  if (all >= parts_.options.max_open_sessions) {
    return absl::ResourceExhaustedError(absl::StrCat(
        "the server has ", all, " open sessions, as many as it may: finish those that are not ",
        "used (isthmus session finish), or raise ingest.max_open_sessions"));
  }
  return absl::OkStatus();
}

void SessionManager::MakeRoom() {
  const MapWriter::View view = parts_.map.view();
  const int64_t now_ns = parts_.clock.NowNs();
  size_t all = 0;
  std::optional<std::pair<int64_t, SessionId>> oldest;
  for (const auto& [id, session] : view->sessions) {
    const SessionRecord& record = session.record;
    if (record.segment > 1 || record.state == SessionState::kFinished) continue;
    ++all;
    if (!session.submaps.empty() || now_ns - record.created_ns < kEmptyForNs) continue;
    if (oldest && oldest->first <= record.created_ns) continue;
    if (StatusOf(*view, session).last_sequence == 0) oldest.emplace(record.created_ns, id);
  }
  if (all < parts_.options.max_open_sessions || !oldest) return;
  (void)Finish(oldest->second, {});
}

void SessionManager::NoteNumbers(const MapView& view) {
  MutexLock changing(&parts_.membership);
  for (const auto& [id, session] : view.sessions) {
    NoteNumber(session.record.robot, session.record.opened());
  }
  EventQuery gone = {.after = 0};
  gone.kinds = {EventKind::kSessionDeleted, EventKind::kSessionExpired};
  while (true) {
    const absl::StatusOr<EventPage> page = parts_.store->ListEvents(gone);
    if (!page.ok() || page->events.empty()) return;
    for (const Event& event : page->events) NoteNumber(event.robot, event.session);
    gone.after = page->up_to;
  }
}

void SessionManager::NoteNumber(const RobotId& robot, const SessionId& session) {
  absl::string_view number = session.value();
  int value = 0;
  if (!absl::ConsumePrefix(&number, absl::StrCat(robot.value(), "-")) ||
      !absl::SimpleAtoi(number, &value) || value > kMaxNumber) {
    return;
  }
  int& last = last_numbers_[robot];
  last = std::max(last, value);
}

SessionId SessionManager::NextId(const RobotId& robot, int* number) const {
  const MapWriter::View view = parts_.map.view();
  while (true) {
    SessionId id(absl::StrCat(robot.value(), "-", ++*number));
    const bool is_robot = view->Newest(RobotId(id.value())) != nullptr;
    if (!is_robot && view->Find(id) == nullptr && parts_.scans->Bytes(id) == 0) return id;
  }
}

std::optional<SessionStatus> SessionManager::FindRequested(const SessionRecord& record) const {
  if (record.request_id.empty()) return std::nullopt;
  const MapWriter::View view = parts_.map.view();
  for (const auto& [id, session] : view->sessions) {
    const bool same =
        session.record.robot == record.robot && session.record.request_id == record.request_id;
    if (same) return StatusOf(*view, session);
  }
  return std::nullopt;
}

absl::StatusOr<SessionStatus> SessionManager::Finish(const SessionId& session, const Actor& by) {
  if (absl::Status status = parts_.check_takes_changes(); !status.ok()) return status;
  {
    const MapWriter::View view = parts_.map.view();
    const auto opened = FindOpened(*view, session);
    if (!opened.ok()) return opened.status();
    if ((*opened)->record.state == SessionState::kFinished) return StatusOf(*view, **opened);
  }
  const Worker worker = parts_.workers.Find(session).worker;
  if (absl::Status status = parts_.scans->Finish(session); !status.ok()) return status;
  if (worker != nullptr) {
    if (absl::Status status = worker->Finish(); !status.ok()) return status;
  }
  MutexLock uploading(&parts_.UploadsOf(session));
  MutexLock changing(&parts_.membership);
  std::vector<SessionRecord> records;
  {
    const MapWriter::View view = parts_.map.view();
    for (const SessionView* segment : view->SegmentsOf(session)) records.push_back(segment->record);
  }
  if (records.empty()) return UnknownSession(session);
  if (worker != nullptr) records.front().scans = worker->Status().scans;
  const int64_t now_ns = parts_.clock.NowNs();
  for (SessionRecord& record : records) {
    record.state = SessionState::kFinished;
    record.finished_ns = now_ns;
  }
  const Event event = SessionEvent(EventKind::kSessionFinished, records.front(), by);
  if (auto status = parts_.map.PutSessions(records, event); !status.ok()) return status;
  // No ack follows the last one, and their receiver may be gone before the worker is.
  if (worker != nullptr) worker->SetAckSink(nullptr);
  parts_.workers.Release(session);
  parts_.retention->NoteChange(session);
  return Get(session);
}

absl::Status SessionManager::Delete(const SessionId& session, const Actor& by) {
  absl::Status status = parts_.check_takes_changes();
  if (status.ok()) status = Remove(session, "", by);
  if (status.ok()) parts_.retention->NoteChange(session);
  return status;
}

// Its scans go first: what is left if that stops half way is a session without.
absl::Status SessionManager::Remove(const SessionId& session, const std::string& why,
                                    const Actor& by) {
  {
    const MapWriter::View view = parts_.map.view();
    const auto opened = FindOpened(*view, session);
    if (!opened.ok()) return opened.status();
  }
  if (const Worker worker = parts_.workers.Find(session).worker) worker->Abandon();
  {
    MutexLock uploading(&parts_.UploadsOf(session));
    MutexLock changing(&parts_.membership);
    if (absl::Status status = parts_.scans->Remove(session); !status.ok()) return status;
    if (absl::Status status = parts_.map.RemoveSession(session, why, by); !status.ok())
      return status;
    parts_.workers.Remove(session);
  }
  parts_.map.WaitUntilPlaced();
  return absl::OkStatus();
}

}  // namespace isthmus::server
