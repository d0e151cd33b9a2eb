#include "client/console/push_scans.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <thread>
#include <utility>

#include "client/console/console.h"
#include "core/stopwatch.h"

namespace isthmus::cli {
namespace {

// Keeps the pace of a robot.
class Pacer {
 public:
  explicit Pacer(std::optional<double> hz) : hz_(hz) {}
  void Wait() {
    if (!hz_) return;
    std::this_thread::sleep_until(start_ + std::chrono::duration<double>(count_++ / *hz_));
  }

 private:
  const std::optional<double> hz_;
  double count_ = 0;
  const std::chrono::time_point<std::chrono::steady_clock, std::chrono::duration<double>> start_ =
      std::chrono::steady_clock::now();
};

// Called by the stream's thread while the scans are pushed, read after it has finished.
class AckLog {
 public:
  AckLog(const std::string& robot, size_t scans) : progress_(robot, scans) {}

  void Add(const ScanAck& ack) {
    if (ack.outcome == ScanOutcome::kRejected) {
      if (first_rejection.empty()) first_rejection = ack.reason;
      absl::FPrintF(stderr, "isthmus: scan %d was rejected: %s\n", ack.sequence, ack.reason);
    }
    NoteSegment(ack);
    acks.push_back(ack);
    progress_.Update(acks.size() + unreadable);
  }

  std::vector<ScanAck> acks;
  std::string first_rejection;
  std::atomic<uint64_t> unreadable{0};  // Counted by the robot's thread.

 private:
  void NoteSegment(const ScanAck& ack) {
    uint32_t& segment = segments_.try_emplace(ack.session, 1).first->second;
    if (ack.segment <= segment) return;
    segment = ack.segment;
    absl::FPrintF(stderr,
                  "isthmus: from scan %d on in segment %d (%s): the robot was lost and not found "
                  "again; poses of different segments share no frame\n",
                  ack.sequence, ack.segment, ack.segment_session.value());
  }

  Progress progress_;
  std::map<SessionId, uint32_t> segments_;
};

absl::Status PushAll(client::ScanStream& stream, const readers::ScanFolder& folder,
                     const PushOptions& options, AckLog& log) {
  Pacer pacer(options.pace_hz);
  const int64_t taken_ns = stream.resumed().last_stamp_ns;  // 0: none were.
  for (size_t i = 0; i < folder.size(); ++i) {
    if (taken_ns != 0 && folder.stamp_ns(i) <= taken_ns) continue;
    absl::StatusOr<PointPayload> scan = folder.Read(i);
    pacer.Wait();
    const absl::Status status =
        scan.ok() ? stream.Push(folder.stamp_ns(i), *std::move(scan)) : scan.status();
    if (!scan.ok() || absl::IsInvalidArgument(status)) {
      ++log.unreadable;
      absl::FPrintF(stderr, "isthmus: left out %s: %s\n", folder.file(i),
                    std::string(status.message()));
    } else if (!status.ok()) {
      return status;
    }
  }
  return stream.Finish();
}

absl::StatusOr<std::unique_ptr<client::ScanStream>> OpenStream(
    client::Client& client, const PushOptions& options, client::ScanStreamOptions stream_options) {
  stream_options.spool_dir = options.spool;
  if (options.spool.empty()) {
    const auto session = client.CreateSession(options.robot, options.sensor, {}, options.odometry);
    if (!session.ok()) return session.status();
    return client.OpenScanStream(session->record.id, stream_options);
  }
  stream_options.on_event = [](const std::string& event) {
    absl::FPrintF(stderr, "isthmus: %s\n", event);
  };
  auto stream = client.ResumeScanStream(stream_options);
  if (absl::IsNotFound(stream.status())) {
    return client.OpenSpool({RobotId(options.robot), options.sensor, options.odometry},
                            stream_options);
  }
  if (stream.ok() && (*stream)->resumed().robot != options.robot) {
    return absl::FailedPreconditionError(
        absl::StrCat("the spool ", options.spool, " holds scans of robot ",
                     (*stream)->resumed().robot, ": name another folder with --spool"));
  }
  return stream;
}

}  // namespace

absl::StatusOr<PushSummary> PushFolder(client::Client& client, const readers::ScanFolder& folder,
                                       const PushOptions& options) {
  AckLog log(options.robot, folder.size());
  client::ScanStreamOptions stream_options;
  stream_options.resolution_m = options.resolution_m;
  stream_options.on_ack = [&log](const ScanAck& ack) { log.Add(ack); };
  auto stream = OpenStream(client, options, stream_options);
  if (!stream.ok()) return stream.status();

  PushSummary summary;
  summary.before = (*stream)->resumed().last_sequence;
  const Stopwatch watch;
  absl::Status status = PushAll(**stream, folder, options, log);
  if (!status.ok()) return status;
  summary.session = (*stream)->session();
  const auto state =
      options.finish ? (*stream)->FinishSession() : client.GetSession(summary.session);
  if (!state.ok()) return state.status();
  summary.state = *state;
  summary.seconds = watch.Ms() / 1000;
  summary.scans = (*stream)->stats();
  summary.unreadable = log.unreadable;
  summary.acks = std::move(log.acks);
  summary.first_rejection = std::move(log.first_rejection);
  for (const ScanAck& ack : summary.acks) summary.mean_ms += ack.timing.total_ms;
  if (summary.scans.processed > 0) {
    summary.mean_ms /= static_cast<double>(summary.scans.processed);
  }
  return summary;
}

}  // namespace isthmus::cli
