#include "lab/loadgen/load_run.h"

#include <absl/strings/str_cat.h>
#include <time.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <utility>

#include "core/stopwatch.h"
#include "lab/loadgen/connection_churn.h"
#include "lab/loadgen/idle_robots.h"
#include "lab/loadgen/limits.h"

namespace isthmus::loadgen {
namespace {

double OwnCpuS() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// Seconds by which a robot sets out later with so many before it on its drive.
double BehindS(size_t robots) { return static_cast<double>(robots) * kFollowS; }

RobotPlan PlanOf(const LoadOptions& options, const Drives& drives, int robot) {
  const auto i = static_cast<size_t>(robot);
  RobotPlan plan;
  plan.name = absl::StrCat(options.prefix, "_", robot);
  plan.server = options.server;
  plan.drive = drives[i % drives.size()];
  plan.first_scan = static_cast<size_t>(BehindS(i / drives.size()) * options.rate_hz);
  plan.scans = static_cast<size_t>(options.seconds * options.rate_hz);
  plan.rate_hz = options.rate_hz;
  // Sensors do not turn in step.
  plan.start_s = static_cast<double>(robot) / options.robots / options.rate_hz;
  plan.jitter_s = options.jitter_s;
  plan.link = options.link;
  plan.when_behind = options.when_behind;
  plan.seed = options.seed * 1000 + i;
  return plan;
}

std::vector<RobotPlan> PlansOf(const LoadOptions& options, const Drives& drives) {
  std::vector<RobotPlan> plans;
  for (int i = 0; i < options.robots; ++i) plans.push_back(PlanOf(options, drives, i));
  return plans;
}

std::vector<RobotPlan> PlansBeside(const LoadOptions& options, const Drives& drives) {
  std::vector<RobotPlan> plans;
  const Drives dense = options.dense > 0 ? MakeDenseDrive(options.dense_points) : Drives();
  for (int i = 0; i < options.dense + options.backfill; ++i) {
    const bool is_dense = i < options.dense;
    RobotPlan plan = PlanOf(options, is_dense ? dense : drives, i);
    plan.name = absl::StrCat(options.prefix, is_dense ? "_dense_" : "_late_", i);
    plan.first_scan = 0;
    plan.rate_hz = is_dense ? options.rate_hz : 0;
    plan.is_beside = true;
    plans.push_back(plan);
  }
  return plans;
}

// Also finds out that there is a server: robots would look for it for minutes.
absl::Status OpenEmpty(const LoadOptions& options) {
  client::ClientOptions at;
  at.address = options.server;
  at.backoff.max_attempts = kFirstAttempts;
  const auto client = client::Client::Connect(at);
  absl::Status status = client.status();
  for (int i = 0; i < options.empty && status.ok(); ++i) {
    status = (*client)->CreateSession(absl::StrCat(options.prefix, "_empty_", i), "vlp16").status();
  }
  return status;
}

class Fleet {
 public:
  explicit Fleet(const std::vector<RobotPlan>& plans) {
    for (const RobotPlan& plan : plans) robots_.push_back(std::make_unique<LoadRobot>(plan));
    for (const auto& robot : robots_) {
      threads_.emplace_back([this, raw = robot.get()] {
        raw->Run();
        ++done_;
      });
    }
  }
  ~Fleet() { Join(); }

  bool done() const { return done_ == static_cast<int>(robots_.size()); }
  void Stop() {
    for (const auto& robot : robots_) robot->Stop();
  }
  uint64_t acknowledged() const {
    uint64_t sum = 0;
    for (const auto& robot : robots_) sum += robot->acknowledged();
    return sum;
  }
  std::vector<RobotResult> Results() {
    Join();
    std::vector<RobotResult> results;
    for (const auto& robot : robots_) results.push_back(robot->Result());
    return results;
  }

 private:
  void Join() {
    for (std::thread& thread : threads_) {
      if (thread.joinable()) thread.join();
    }
  }

  std::vector<std::unique_ptr<LoadRobot>> robots_;
  std::atomic<int> done_ = 0;
  std::vector<std::thread> threads_;
};

}  // namespace

double DriveSeconds(const LoadOptions& options, size_t drives) {
  return options.seconds + BehindS((static_cast<size_t>(options.robots) - 1) / drives);
}

absl::StatusOr<LoadResult> RunLoad(const LoadOptions& options, const Drives& drives,
                                   const std::function<bool(uint64_t acknowledged)>& tick) {
  LoadResult result;
  const double disk_before_mb = FolderMb(options.data_folder);
  const auto watch = [&](double at_s) -> absl::Status {
    if (options.server_pid == 0) return absl::OkStatus();
    const auto use = UseOf(options.server_pid);
    if (use.ok()) result.server.push_back({at_s, *use});
    return use.status();
  };
  if (absl::Status status = watch(0); !status.ok()) return status;
  if (absl::Status status = OpenEmpty(options); !status.ok()) return status;
  const auto idle = IdleRobots::Open(options.server, options.idle, *drives.front());
  if (!idle.ok()) return idle.status();
  const std::map<std::string, double> threads_before = ThreadCpuS(options.server_pid);
  const double cpu_before_s = OwnCpuS();
  const Stopwatch clock;
  ConnectionChurn churn(options.server, options.knocks_per_s);
  MisbehavingClients misbehaving(options.server, options.misbehaving, options.seed);
  {
    LoadReaders readers(options.server, options.readers, options.reader_period_s);
    Fleet beside(PlansBeside(options, drives));
    Fleet fleet(PlansOf(options, drives));
    while (!fleet.done()) {
      std::this_thread::sleep_for(std::chrono::seconds(1));
      // A server that has gone is told by the robots.
      (void)watch(clock.Ms() / 1e3);
      if (!tick(fleet.acknowledged())) fleet.Stop();
    }
    result.robots = fleet.Results();
    result.thread_cpu_s = ThreadCpuS(options.server_pid);
    for (const auto& [name, cpu_s] : threads_before) result.thread_cpu_s[name] -= cpu_s;
    beside.Stop();
    result.beside = beside.Results();
    result.readers = readers.Results();
  }
  result.seconds = clock.Ms() / 1e3;
  (void)watch(result.seconds);
  result.generator_cpu_s = OwnCpuS() - cpu_before_s;
  result.disk_mb = FolderMb(options.data_folder) - disk_before_mb;
  result.knocks = churn.made();
  result.knocks_refused = churn.refused();
  result.misbehaving = misbehaving.Result();
  return result;
}

}  // namespace isthmus::loadgen
