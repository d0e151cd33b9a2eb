#include "lab/bench/readers/fleet.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <set>
#include <thread>
#include <utility>

#include "core/codec/payload_builder.h"
#include "core/concurrency/mutex.h"
#include "lab/simulation/simulator.h"

namespace isthmus::bench {
namespace {

using SteadyClock = std::chrono::steady_clock;

constexpr int kDrives = 2, kDirections = 360;

// One point of a ring in each direction.
Scan Thin(const Scan& scan) {
  Scan thin = scan;
  thin.points.clear();
  std::set<std::pair<int, int>> taken;
  for (const ScanPoint& point : scan.points) {
    const int direction =
        static_cast<int>((std::atan2(point.y, point.x) + M_PI) / (2 * M_PI) * kDirections);
    if (taken.insert({point.ring, direction}).second) thin.points.push_back(point);
  }
  return thin;
}

// Takes down when each scan was handed over and when its acknowledgement came. Thread safe.
class Timing {
 public:
  explicit Timing(int first, int scans) : first_(first), sent_(static_cast<size_t>(scans)) {}

  void Send(uint64_t sequence) {
    MutexLock lock(&mutex_);
    sent_[Index(sequence)] = SteadyClock::now();
  }
  void Acknowledge(const ScanAck& ack) {
    const auto now = SteadyClock::now();
    MutexLock lock(&mutex_);
    if (ack.sequence <= static_cast<uint64_t>(first_)) return;
    const std::chrono::duration<double, std::milli> took = now - sent_[Index(ack.sequence)];
    ms_.push_back(took.count());
    changed_.SignalAll();
  }
  // Once all are acknowledged.
  std::vector<double> Take() {
    MutexLock lock(&mutex_);
    while (ms_.size() != sent_.size()) changed_.Wait(&mutex_);
    return std::move(ms_);
  }

 private:
  size_t Index(uint64_t sequence) const { return sequence - 1 - static_cast<size_t>(first_); }

  const int first_;
  Mutex mutex_;
  CondVar changed_;
  std::vector<SteadyClock::time_point> sent_ ABSL_GUARDED_BY(mutex_);
  std::vector<double> ms_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

Fleet::Fleet(const FleetOptions& options, server::Pipeline* pipeline)
    : options_(options), pipeline_(pipeline) {
  simulation::Options simulated;
  simulated.robots = kDrives;
  simulated.seed = 5;
  simulated.seconds = options.scans / 10.0 + 1;
  const auto simulator = simulation::Simulator::Create(simulated).value();
  drives_.resize(kDrives);
  std::vector<std::thread> threads;
  for (int drive = 0; drive < kDrives; ++drive) {
    threads.emplace_back([&, drive] {
      for (int index = 0; index < options.scans; ++index) {
        const Scan scan = Thin(simulator->MakeScan(drive, index));
        drives_[static_cast<size_t>(drive)].push_back(
            {scan.sequence, scan.end_stamp_ns, codec::MakePayload(scan)});
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (int robot = 0; robot < options.robots; ++robot) {
    SessionRequest request;
    request.robot = RobotId(absl::StrFormat("robot-%d", robot));
    request.sensor = "vlp16";
    sessions_.push_back(pipeline_->sessions().Create(request).value().record.id);
  }
}

std::vector<double> Fleet::Drive(int scans) {
  const int first = std::exchange(sent_, sent_ + scans);
  const auto begin = SteadyClock::now();
  Mutex mutex;
  std::vector<double> all;  // Guarded by mutex.
  std::vector<std::thread> threads;
  for (size_t robot = 0; robot < sessions_.size(); ++robot) {
    threads.emplace_back([&, robot] {
      Timing timing(first, scans);
      const SessionId& session = sessions_[robot];
      const auto sink = [&timing](const ScanAck& ack) { timing.Acknowledge(ack); };
      if (!pipeline_->sessions().SetAckSink(session, sink).ok()) std::abort();
      // The robots' turns do not fall together.
      const double phase = static_cast<double>(robot) / static_cast<double>(sessions_.size());
      for (int i = 0; i < scans; ++i) {
        const double due_s = (i + phase) / options_.rate_hz;
        std::this_thread::sleep_until(begin + std::chrono::microseconds(int64_t(1e6 * due_s)));
        ScanUpload scan = drives_[robot % kDrives].at(static_cast<size_t>(first + i));
        timing.Send(scan.sequence);
        if (!pipeline_->sessions().SubmitScan(session, std::move(scan)).ok()) std::abort();
      }
      const std::vector<double> ms = timing.Take();
      if (!pipeline_->sessions().SetAckSink(session, nullptr).ok()) std::abort();
      MutexLock lock(&mutex);
      all.insert(all.end(), ms.begin(), ms.end());
    });
  }
  for (std::thread& thread : threads) thread.join();
  std::sort(all.begin(), all.end());
  return all;
}

double Fleet::odometry_ms() const {
  double sum = 0;
  for (const SessionId& id : sessions_)
    sum += pipeline_->sessions().Get(id).value().odometry_ms_mean;
  return sum / static_cast<double>(sessions_.size());
}

double Fleet::tracked() const {
  double ok = 0, all = 0;
  for (const SessionId& id : sessions_) {
    const ScanCounts scans = pipeline_->sessions().Get(id).value().scans;
    ok += static_cast<double>(scans.ok + scans.degenerate);
    all += static_cast<double>(scans.ok + scans.degenerate + scans.lost + scans.rejected);
  }
  return ok / all;
}

}  // namespace isthmus::bench
