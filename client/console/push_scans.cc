#include "client/console/push_scans.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <thread>
#include <utility>

#include "client/console/console.h"
#include "client/console/pacer.h"
#include "client/console/push_keyframes.h"
#include "client/console/pushed_recording.h"
#include "client/console/reason_tally.h"
#include "client/console/say.h"
#include "client/console/taken_scans.h"
#include "core/stopwatch.h"

namespace isthmus::cli {
namespace {

// One bar for all robots. Thread safe.
class FleetProgress {
 public:
  explicit FleetProgress(const std::vector<RobotScans>& robots)
      : progress_(Name(robots), Total(robots)) {}

  void CountOne() {
    MutexLock lock(&mutex_);
    progress_.Update(++done_);
  }

 private:
  static std::string Name(const std::vector<RobotScans>& robots) {
    if (robots.size() > 3) return absl::StrCat(robots.size(), " robots");
    return absl::StrJoin(robots, "+", [](std::string* out, const RobotScans& robot) {
      absl::StrAppend(out, robot.robot);
    });
  }
  static uint64_t Total(const std::vector<RobotScans>& robots) {
    uint64_t total = 0;
    for (const RobotScans& robot : robots) {
      if (!robot.reader->size()) return 0;
      total += *robot.reader->size();
    }
    return total;
  }

  Mutex mutex_;
  Progress progress_ ABSL_GUARDED_BY(mutex_);
  uint64_t done_ ABSL_GUARDED_BY(mutex_) = 0;
};

// Called by the stream's thread while the scans are pushed, read after it has finished.
class AckLog {
 public:
  AckLog(const RobotScans& robot, FleetProgress& progress)
      : robot_(robot.robot), progress_(progress) {}

  void Add(const ScanAck& ack) {
    if (ack.outcome == ScanOutcome::kRejected) {
      if (first_rejection.empty()) first_rejection = ack.reason;
      if (rejections_.Count(ack.reason)) {
        Warn("isthmus: scan %d was rejected: %s\n", ack.sequence, ack.reason);
      }
    }
    NoteSegment(ack);
    acks.push_back(ack);
    progress_.CountOne();
  }
  // By the robot's thread.
  void LeaveOut(const std::string& name, const absl::Status& why) {
    ++unreadable;
    progress_.CountOne();
    const std::string reason(why.message());
    if (!left_out_.Count(reason)) return;
    Warn("isthmus: left out %s%s%s\n", name, name.empty() ? "" : ": ", reason);
  }
  // Once the stream has ended.
  void SayTheRest() const {
    for (const auto& [reason, count] : left_out_.Unsaid()) {
      Warn("isthmus: %s: left out %d more for the same reason: %s\n", robot_, count, reason);
    }
    for (const auto& [reason, count] : rejections_.Unsaid()) {
      Warn("isthmus: %s: %d more scans were rejected for the same reason: %s\n", robot_, count,
           reason);
    }
  }

  std::vector<ScanAck> acks;
  std::string first_rejection;
  uint64_t unreadable = 0;

 private:
  void NoteSegment(const ScanAck& ack) {
    uint32_t& segment = segments_.try_emplace(ack.session, 1).first->second;
    if (ack.segment <= segment) return;
    segment = ack.segment;
    Warn(
        "isthmus: %s: from scan %d on in segment %d%s: the robot was lost and not "
        "found again; poses of different segments share no frame\n",
        robot_, ack.sequence, ack.segment,
        ack.segment_session.empty() ? "" : absl::StrCat(" (", ack.segment_session.value(), ")"));
  }

  const std::string robot_;
  FleetProgress& progress_;
  std::map<SessionId, uint32_t> segments_;
  ReasonTally rejections_, left_out_;
};

// Nothing where the spool is sound, or the server does not say.
std::optional<ServerEnd> AskForEnd(client::Client& client, const client::SpoolState& spool) {
  if (!spool.server_ahead) return std::nullopt;
  const auto way =
      client.GetTrajectory(RobotId(spool.session.value()), TrajectoryFrame::kOdom, /*segment=*/0);
  const auto session = client.GetSession(spool.session);
  if (!session.ok() || !way.ok() || way->poses.empty()) return std::nullopt;
  const ScanCounts& scans = session->scans;
  const uint64_t late =
      session->last_sequence - std::min(session->last_sequence, spool.server_sequence);
  return ServerEnd{way->poses.back().stamp_ns, scans.rejected + scans.skipped + scans.lost, late};
}

absl::Status PushAll(client::Client& client, client::ScanStream& stream, const RobotScans& robot,
                     const PushOptions& options, const PushControl& control, AckLog& log,
                     RecordingSum& sum) {
  Pacer pacer(options.pace_hz);
  // A live sensor does not say the same again.
  TakenScans taken(
      robot, options.is_live ? client::SpoolState() : stream.resumed(),
      [&stream](const readers::RecordedScan& scan) {
        return stream.IsNewest(scan.end_stamp_ns, scan.payload);
      },
      [&control] { return control.stopped(); }, AskForEnd(client, stream.resumed()));
  if (!taken.status().ok()) return taken.status();
  while (!control.stopped()) {
    absl::StatusOr<std::optional<readers::RecordedScan>> scan = robot.reader->Next();
    if (!scan.ok()) {
      log.LeaveOut("", scan.status());
      continue;
    }
    if (!scan->has_value()) break;
    readers::RecordedScan& one = **scan;
    sum.Add(one);
    if (taken.Take(one.end_stamp_ns)) continue;
    pacer.Wait();
    const absl::Status status = stream.Push(one.end_stamp_ns, std::move(one.payload));
    if (absl::IsInvalidArgument(status)) {
      log.LeaveOut(one.name, status);
    } else if (!status.ok()) {
      return status;
    }
  }
  if (taken.by_stamp() > 0) {
    Warn(
        "isthmus: %s: %d scans were left out: they are not later than the last scan in the spool, "
        "which is not among them\n",
        robot.robot, taken.by_stamp());
  }
  return stream.Finish();
}

// Finishing empties the spool: from then on the note alone tells that the recording is not new.
absl::Status NoteBeforeFinish(client::Client& client, const client::ScanStream& stream,
                              const std::string& spool, const PushControl& control,
                              const RecordingSum& sum) {
  const auto session = AwaitSession(client, stream.session(), control);
  if (absl::IsCancelled(session.status())) return session.status();
  // FinishSession says why. A session with fewer has the end alone, as --new-session leaves it.
  if (!session.ok() || session->last_sequence < sum.scans()) return absl::OkStatus();
  return NotePushed(spool, sum, *session);
}

absl::Status PushAndConclude(client::Client& client, client::ScanStream& stream,
                             const RobotScans& robot, const PushOptions& options,
                             PushControl& control, AckLog& log, PushSummary& summary) {
  RecordingSum sum;
  absl::Status status = PushAll(client, stream, robot, options, control, log, sum);
  const bool has_spool = !options.spool.empty();
  if (status.ok() && has_spool && options.finish && !options.is_live && !control.stopped()) {
    status = NoteBeforeFinish(client, stream, options.spool, control, sum);
  }
  const bool is_kept = control.stopped() && has_spool;
  if (!status.ok() && !(is_kept && absl::IsCancelled(status))) return status;
  log.SayTheRest();
  summary.session = stream.session();
  summary.is_interrupted = control.stopped();  // A later stop interrupts nothing.
  if (is_kept) return absl::OkStatus();        // Its server may be gone: it is not asked.
  const auto state = options.finish ? stream.FinishSession() : client.GetSession(summary.session);
  // All is acknowledged: only the report wants to know more.
  if (!options.finish && IsAway(state.status())) return absl::OkStatus();
  if (!state.ok()) return state.status();
  summary.state = *state;
  summary.has_state = true;
  return absl::OkStatus();
}

// A push that was killed leaves its session open, and nothing else would tell.
void SayWhatIsOpen(client::Client& client, const SessionStatus& opened) {
  const auto sessions = client.ListSessions();
  if (!sessions.ok()) return;
  for (const SessionStatus& other : *sessions) {
    if (other.record.robot != opened.record.robot || other.record.id == opened.record.id ||
        other.record.state == SessionState::kFinished || other.record.segment > 1) {
      continue;
    }
    Warn(
        "isthmus: %s is still open, with %d scans: if its program died, `isthmus session "
        "finish %s`\n",
        other.record.id.value(), other.last_sequence, other.record.id.value());
  }
}

// The part in the map of a drive that has to be given up, and the user's options: `why`, which ends
// the drive, speaks to programs. Without a spool, scans that were sent and are not durable end with
// this program.
std::string WhatIsLeft(client::Client& client, const client::ScanStream& stream,
                       const absl::Status& why) {
  const std::string id = stream.session().value();
  const client::ScanStreamStats stats = stream.stats();
  const std::string again = absl::StrCat("push again, and remove it with `isthmus session delete ",
                                         id, "`; with --spool DIR a push continues where it ended");
  if (absl::IsNotFound(why)) {
    return absl::StrCat("session ", id, " was deleted with all pushed scans: push again");
  }
  // One that is out of reach would be waited for once more.
  const auto session = absl::IsUnavailable(why) ? absl::StatusOr<SessionStatus>(why)
                                                : client.GetSession(stream.session());
  if (session.ok()) {
    const bool finished = session->record.state == SessionState::kFinished;
    return absl::StrCat("session ", id, finished ? " is finished" : " stays open", ", with ",
                        session->last_sequence, " of the ", stats.pushed, " pushed scans: ", again);
  }
  return absl::StrCat(
      "session ", id, " has ", stats.durable_sequence, " of the ", stats.pushed,
      " pushed scans, or more: once the server can be reached, `isthmus session list` shows the "
      "number and whether the session is open. If scans are missing, ",
      again);
}

absl::Status Explain(const std::string& left, const absl::Status& why) {
  return absl::Status(why.code(), absl::StrCat(left, " (", why.message(), ")"));
}

// A program that did not read this recording cannot tell that the session has all of it.
absl::Status FinishedElsewhere(const absl::Status& why) {
  return absl::FailedPreconditionError(absl::StrCat(
      why.message(),
      ", and nothing tells that it has all of this recording: nothing was sent, and the spool is "
      "empty now. The same command pushes the whole recording into a new session"));
}

// AlreadyExists where the recording is whole in `pushed` and nothing is left to push.
absl::StatusOr<std::unique_ptr<client::ScanStream>> OpenStream(
    client::Client& client, const RobotScans& robot, const PushOptions& options,
    const PushControl& control, client::ScanStreamOptions stream_options,
    std::optional<SessionStatus>& pushed) {
  stream_options.spool_dir = options.spool;
  stream_options.spool.is_replayed = !options.is_live;
  if (options.new_session) {
    stream_options.spool.if_session_is_gone = client::IfSessionIsGone::kNewSession;
  }
  // The server skips, so that the sender need not wait.
  if (options.session.when_behind == WhenBehind::kKeepNewest) stream_options.window = 64;
  stream_options.on_event = [name = robot.robot](const std::string& event) {
    Warn("isthmus: %s: %s\n", name, event);
  };
  if (options.spool.empty()) {
    const auto session = client.CreateSession(RequestOf(robot, options));
    if (!session.ok()) return session.status();
    SayWhatIsOpen(client, *session);
    return client.OpenScanStream(session->record.id, stream_options);
  }
  auto stream = client.ResumeScanStream(stream_options);
  const bool was_finished = absl::IsAlreadyExists(stream.status());
  if (absl::IsNotFound(stream.status()) || was_finished) {
    if (options.is_live) return client.OpenSpool(RequestOf(robot, options), stream_options);
    auto found = FindPushed(client, robot, options.spool, control);
    if (!found.ok()) return found.status();
    pushed = *found;
    if (pushed) return absl::AlreadyExistsError("nothing is left to push");
    if (was_finished) return FinishedElsewhere(stream.status());
    return client.OpenSpool(RequestOf(robot, options), stream_options);
  }
  if (stream.ok() && (*stream)->resumed().robot != robot.robot) {
    return absl::FailedPreconditionError(
        absl::StrCat("the spool ", options.spool, " holds scans of robot ",
                     (*stream)->resumed().robot, ": name another folder with --spool"));
  }
  if (stream.ok() && (*stream)->resumed().sensor != robot.sensor) {
    Warn("isthmus: %s: the scans go on in a session of sensor %s, not %s: its sensor stays\n",
         robot.robot, (*stream)->resumed().sensor, robot.sensor);
  }
  return stream;
}

PushSummary SummaryOf(const RobotScans& robot) {
  PushSummary summary;
  summary.robot = robot.robot;
  summary.sensor = robot.sensor;
  return summary;
}

// The facts about the scans that both ways of pushing report.
void TakeLog(AckLog& log, const RobotScans& robot, PushSummary& summary) {
  summary.unreadable = log.unreadable;
  summary.acks = std::move(log.acks);
  summary.first_rejection = std::move(log.first_rejection);
  summary.assumptions = robot.reader->Assumptions();
  for (const std::string& assumption : summary.assumptions) {
    const auto& said = robot.assumptions;
    if (std::find(said.begin(), said.end(), assumption) != said.end()) continue;
    Warn("isthmus: %s: %s\n", robot.robot, assumption);
  }
  if (summary.scans.processed == 0) return;
  double sum_ms = 0;
  for (const ScanAck& ack : summary.acks) sum_ms += ack.timing.total_ms;
  summary.mean_ms = sum_ms / static_cast<double>(summary.scans.processed);
}

absl::StatusOr<PushSummary> PushRobotsKeyframes(client::Client& client, RobotScans& robot,
                                                const PushOptions& options,
                                                const PushControl& control, AckLog& log) {
  const KeyframeHooks hooks{
      [&log](const ScanAck& ack) { log.Add(ack); },
      [&log](const std::string& name, const absl::Status& why) { log.LeaveOut(name, why); }};
  const Stopwatch watch;
  const auto pushed = PushKeyframes(client, robot, options, control, hooks);
  if (!pushed.ok()) return pushed.status();
  log.SayTheRest();
  PushSummary summary = SummaryOf(robot);
  summary.session = pushed->session;
  summary.scans = pushed->scans;
  summary.is_interrupted = control.stopped();
  if (!summary.session.empty()) {
    const auto state = client.GetSession(summary.session);
    if (!state.ok()) return state.status();
    summary.state = *state;
  }
  summary.state.scans = pushed->counts;
  summary.state.segments = pushed->segments;
  summary.has_state = true;
  summary.durable_sequence = pushed->durable_sequence;
  summary.seconds = watch.Ms() / 1000;
  TakeLog(log, robot, summary);
  return summary;
}

PushSummary SummaryOfPushed(const RobotScans& robot, const PushOptions& options,
                            const SessionStatus& pushed) {
  Warn(
      "isthmus: %s: nothing left to push: the whole recording is in session %s, which is finished; "
      "to push it once more, remove %s\n",
      robot.robot, pushed.record.id.value(), options.spool);
  PushSummary summary = SummaryOf(robot);
  summary.session = pushed.record.id;
  summary.before = pushed.last_sequence;
  summary.durable_sequence = pushed.durable_sequence;
  summary.state = pushed;
  summary.has_state = true;
  return summary;
}

absl::StatusOr<PushSummary> PushRobot(client::Client& client, RobotScans& robot,
                                      const PushOptions& options, PushControl& control,
                                      FleetProgress& progress) {
  AckLog log(robot, progress);
  if (options.keyframes) return PushRobotsKeyframes(client, robot, options, control, log);
  client::ScanStreamOptions stream_options;
  stream_options.resolution_m = options.resolution_m;
  stream_options.on_ack = [&log](const ScanAck& ack) { log.Add(ack); };
  PushSummary summary = SummaryOf(robot);
  std::optional<SessionStatus> pushed;
  auto stream = OpenStream(client, robot, options, control, stream_options, pushed);
  if (pushed) return SummaryOfPushed(robot, options, *pushed);
  if (absl::IsCancelled(stream.status()) && control.stopped()) {
    summary.is_interrupted = true;
    return summary;
  }
  if (!stream.ok()) return stream.status();
  std::optional<PushControl::GivenUp> given_up;
  if (!options.spool.empty()) given_up.emplace(control, stream->get());

  const client::SpoolState resumed = (*stream)->resumed();
  const int64_t ahead = std::max<int64_t>(resumed.server_ahead.value_or(0), 0);
  summary.before = resumed.last_sequence + static_cast<uint64_t>(ahead);
  const Stopwatch watch;
  const absl::Status status =
      PushAndConclude(client, **stream, robot, options, control, log, summary);
  if (!status.ok()) {
    return options.spool.empty() ? Explain(WhatIsLeft(client, **stream, status), status) : status;
  }
  summary.seconds = watch.Ms() / 1000;
  summary.scans = (*stream)->stats();
  summary.reconnects = summary.scans.reconnects;
  // One that was stopped may still be taking answers.
  given_up.reset();
  stream->reset();
  TakeLog(log, robot, summary);
  if (summary.has_state || !summary.acks.empty()) {
    summary.durable_sequence = summary.scans.durable_sequence;
  }
  return summary;
}

}  // namespace

SessionRequest RequestOf(const RobotScans& robot, const PushOptions& options) {
  SessionRequest request = options.session;
  request.robot = RobotId(robot.robot);
  request.sensor = robot.sensor;
  request.T_base_sensor = robot.T_base_sensor.value_or(Pose());
  return request;
}

bool PushControl::Stop() {
  MutexLock lock(&mutex_);
  if (robots_ == nullptr) return false;
  stopped_ = true;
  for (RobotScans& robot : *robots_) robot.reader->Interrupt();
  for (client::ScanStream* stream : spooled_) stream->GiveUp();
  return true;
}

PushControl::GivenUp::GivenUp(PushControl& control, client::ScanStream* stream)
    : control_(control), stream_(stream) {
  MutexLock lock(&control_.mutex_);
  control_.spooled_.insert(stream_);
  if (control_.stopped_) stream_->GiveUp();
}

PushControl::GivenUp::~GivenUp() {
  MutexLock lock(&control_.mutex_);
  control_.spooled_.erase(stream_);
}

bool PushControl::stopped() const {
  MutexLock lock(&mutex_);
  return stopped_;
}

PushControl::Registration::Registration(PushControl& control, std::vector<RobotScans>* robots)
    : control_(control) {
  MutexLock lock(&control_.mutex_);
  control_.robots_ = robots;
}

PushControl::Registration::~Registration() {
  MutexLock lock(&control_.mutex_);
  control_.robots_ = nullptr;
}

absl::StatusOr<std::vector<PushSummary>> PushRobots(client::Client& client,
                                                    std::vector<RobotScans> robots,
                                                    const PushOptions& options,
                                                    PushControl& control) {
  const PushControl::Registration registered(control, &robots);
  FleetProgress progress(robots);
  std::vector<absl::StatusOr<PushSummary>> results(robots.size());
  std::vector<std::thread> threads;
  for (size_t i = 0; i < results.size(); ++i) {
    PushOptions own = options;
    if (!own.spool.empty() && results.size() > 1) own.spool += "/" + robots[i].robot;
    threads.emplace_back([&client, &robots, &control, &progress, &results, own, i] {
      results[i] = PushRobot(client, robots[i], own, control, progress);
    });
  }
  for (std::thread& thread : threads) thread.join();
  std::vector<PushSummary> summaries;
  for (absl::StatusOr<PushSummary>& result : results) {
    if (!result.ok()) return result.status();
    summaries.push_back(*std::move(result));
  }
  return summaries;
}

}  // namespace isthmus::cli
