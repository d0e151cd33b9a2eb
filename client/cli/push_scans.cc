#include "client/cli/push_scans.h"

#include <absl/strings/str_format.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <memory>
#include <thread>
#include <utility>

#include "client/cli/console.h"
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

  void Add(const client::ScanAck& ack) {
    if (ack.outcome == client::ScanOutcome::kRejected) {
      if (first_rejection.empty()) first_rejection = ack.reason;
      absl::FPrintF(stderr, "isthmus: scan %d was rejected: %s\n", ack.sequence, ack.reason);
    }
    acks.push_back(ack);
    progress_.Update(acks.size() + unreadable);
  }

  std::vector<client::ScanAck> acks;
  std::string first_rejection;
  std::atomic<uint64_t> unreadable{0};  // Counted by the robot's thread.

 private:
  Progress progress_;
};

absl::Status PushAll(client::ScanStream& stream, const readers::ScanFolder& folder,
                     const PushOptions& options, AckLog& log) {
  Pacer pacer(options.pace_hz);
  for (size_t i = 0; i < folder.size(); ++i) {
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

}  // namespace

absl::StatusOr<PushSummary> PushFolder(client::Client& client, const readers::ScanFolder& folder,
                                       const PushOptions& options) {
  absl::StatusOr<client::Session> session =
      client.CreateSession(options.robot, options.sensor, {}, options.odometry);
  if (!session.ok()) return session.status();
  AckLog log(options.robot, folder.size());
  client::ScanStreamOptions stream_options;
  stream_options.resolution_m = options.resolution_m;
  stream_options.on_ack = [&log](const client::ScanAck& ack) { log.Add(ack); };
  auto stream = client.OpenScanStream(session->record.id, stream_options);
  if (!stream.ok()) return stream.status();

  PushSummary summary;
  summary.session = session->record.id;
  const Stopwatch watch;
  absl::Status status = PushAll(**stream, folder, options, log);
  if (!status.ok()) return status;
  if (options.finish) {
    session = client.FinishSession(summary.session);
    if (!session.ok()) return session.status();
  }
  summary.seconds = watch.Ms() / 1000;
  summary.scans = (*stream)->stats();
  if (options.finish) summary.scans.durable_sequence = session->durable_sequence;
  summary.unreadable = log.unreadable;
  summary.acks = std::move(log.acks);
  summary.first_rejection = std::move(log.first_rejection);
  for (const client::ScanAck& ack : summary.acks) summary.mean_ms += ack.timing.total_ms;
  if (summary.scans.processed > 0) {
    summary.mean_ms /= static_cast<double>(summary.scans.processed);
  }
  return summary;
}

}  // namespace isthmus::cli
