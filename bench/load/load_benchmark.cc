// The load of a fleet on a running server: how soon robots' scans are acknowledged, alone and
// beside others that send clouds of millions of points, recordings as fast as they can, or nothing
// at all, and what that costs the server. See docs/benchmarks/load.md.
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_split.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "client/library/client.h"
#include "client/readers/recording.h"
#include "core/codec/payload_builder.h"
#include "core/codec/quantized.h"

namespace isthmus::bench {
namespace {

using SteadyClock = std::chrono::steady_clock;

struct Settings {
  std::string server = "localhost:50051", data;
  int robots = 16, seconds = 60, dense = 0, points = 3'900'000, backfill = 0, empty = 0, pid = 0;
  double rate_hz = 10;
};

struct StampedPayload {
  int64_t end_stamp_ns = 0;
  PointPayload payload;
};
using Drive = std::vector<StampedPayload>;

std::vector<Drive> ReadDrives(const Settings& settings) {
  std::vector<Drive> drives;
  for (int robot = 0;; ++robot) {
    const auto recording = readers::OpenRecording(absl::StrCat(settings.data, "/robot_", robot));
    if (!recording.ok()) return drives;
    const auto reader = (*recording)->OpenScans(0, {}).value();
    Drive& drive = drives.emplace_back();
    for (auto scan = reader->Next(); scan.ok() && scan->has_value(); scan = reader->Next()) {
      drive.push_back({(*scan)->end_stamp_ns, codec::Quantize((*scan)->payload, 0.002).value()});
    }
  }
}

// A room of 20 by 30 m, many points of it.
PointPayload MakeDenseScan(int points) {
  std::vector<ScanPoint> scan(static_cast<size_t>(points));
  for (size_t i = 0; i < scan.size(); ++i) {
    const double angle = 2 * M_PI * static_cast<double>(i) / points;
    const double up = std::tan((static_cast<double>(i % 16) * 2 - 15) * M_PI / 180);
    const double range = std::min(10 / std::abs(std::cos(angle)), 15 / std::abs(std::sin(angle)));
    scan[i].x = static_cast<float>(range * std::cos(angle));
    scan[i].y = static_cast<float>(range * std::sin(angle));
    scan[i].z = static_cast<float>(range * up);
  }
  return codec::MakePayload(scan, false, false);
}

// Times of one robot's scans. Thread safe.
class Timing {
 public:
  void Send(SteadyClock::time_point due) {
    std::lock_guard lock(mutex_);
    due_.push_back(due);
  }
  void Acknowledge(const ScanAck& ack) {
    const auto now = SteadyClock::now();
    std::lock_guard lock(mutex_);
    if (ack.sequence == 0 || ack.sequence > due_.size()) return;
    const std::chrono::duration<double, std::milli> took = now - due_[ack.sequence - 1];
    ms_.push_back(took.count());
    ++outcomes_[static_cast<int>(ack.outcome)];
  }
  void AddTo(std::vector<double>* ms, std::map<int, int>* outcomes, size_t* sent) {
    std::lock_guard lock(mutex_);
    ms->insert(ms->end(), ms_.begin(), ms_.end());
    for (const auto& [outcome, count] : outcomes_) (*outcomes)[outcome] += count;
    *sent += due_.size();
  }

 private:
  std::mutex mutex_;
  std::vector<SteadyClock::time_point> due_;
  std::vector<double> ms_;
  std::map<int, int> outcomes_;
};

struct Robot {
  std::string name;
  const Drive* drive;
  double rate_hz, phase;  // 0 Hz: as fast as it can.
  std::unique_ptr<Timing> timing = std::make_unique<Timing>();
};

void Push(const Settings& settings, Robot& robot, SteadyClock::time_point begin,
          const std::atomic<bool>& stop) {
  auto client = client::Client::Connect({.address = settings.server});
  if (!client.ok()) return (void)absl::FPrintF(stderr, "%s\n", client.status().ToString());
  const auto session = (*client)->CreateSession(robot.name, "vlp16");
  if (!session.ok()) return (void)absl::FPrintF(stderr, "%s\n", session.status().ToString());
  client::ScanStreamOptions options;
  options.on_ack = [&robot](const ScanAck& ack) { robot.timing->Acknowledge(ack); };
  const auto stream = (*client)->OpenScanStream(session->record.id, options).value();
  for (size_t i = 0; !stop; ++i) {
    const auto turn = static_cast<int64_t>(i / robot.drive->size());
    if (turn > 0 && robot.drive->size() > 1) break;
    const StampedPayload& scan = (*robot.drive)[i % robot.drive->size()];
    auto due = SteadyClock::now();
    if (robot.rate_hz > 0) {
      const double due_s = (static_cast<double>(i) + robot.phase) / robot.rate_hz;
      due = begin + std::chrono::microseconds(static_cast<int64_t>(1e6 * due_s));
      std::this_thread::sleep_until(due);
      if (stop) break;
    }
    robot.timing->Send(due);
    const absl::Status pushed =
        stream->Push(scan.end_stamp_ns + turn * 100'000'000, PointPayload(scan.payload));
    if (!pushed.ok()) return (void)absl::FPrintF(stderr, "%s\n", pushed.ToString());
  }
  if (robot.rate_hz > 0 && robot.drive->size() > 1) (void)stream->Finish();
}

// CPU seconds by the names of threads, of /proc.
std::map<std::string, double> CpuOf(int pid) {
  std::map<std::string, double> cpu;
  if (pid == 0) return cpu;
  const auto folder = std::filesystem::path(absl::StrCat("/proc/", pid, "/task"));
  std::error_code error;
  for (const auto& task : std::filesystem::directory_iterator(folder, error)) {
    std::ifstream file(task.path() / "stat");
    const std::string text((std::istreambuf_iterator<char>(file)), {});
    const size_t open = text.find('('), close = text.rfind(')');
    if (close == std::string::npos) continue;
    const std::vector<std::string> rest = absl::StrSplit(text.substr(close + 2), ' ');
    cpu[text.substr(open + 1, close - open - 1)] +=
        (std::stod(rest[11]) + std::stod(rest[12])) / static_cast<double>(sysconf(_SC_CLK_TCK));
  }
  // Threads that have ended count here only.
  std::ifstream file(absl::StrCat("/proc/", pid, "/stat"));
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  const std::vector<std::string> rest = absl::StrSplit(text.substr(text.rfind(')') + 2), ' ');
  cpu["all"] = (std::stod(rest[11]) + std::stod(rest[12])) / sysconf(_SC_CLK_TCK);
  return cpu;
}

void Report(const Settings& settings, const std::string& what, std::vector<Robot>& robots,
            const std::map<std::string, double>& before) {
  std::vector<double> ms;
  std::map<int, int> outcomes;
  size_t sent = 0;
  for (Robot& robot : robots) robot.timing->AddTo(&ms, &outcomes, &sent);
  std::sort(ms.begin(), ms.end());
  const auto quantile = [&](double q) {
    return ms.empty() ? NAN : ms[static_cast<size_t>(q * static_cast<double>(ms.size() - 1))];
  };
  absl::PrintF("%-10s sent %d, acknowledged %d (rejected %d, skipped %d); ", what, sent, ms.size(),
               outcomes[2], outcomes[3]);
  absl::PrintF("ms: p50 %.1f, p99 %.1f, most %.1f\n", quantile(0.5), quantile(0.99), quantile(1));
  if (what != "live" || settings.pid == 0 || ms.empty()) return;
  for (const auto& [name, seconds] : CpuOf(settings.pid)) {
    const auto old = before.find(name);
    const double used = seconds - (old == before.end() ? 0 : old->second);
    if (used < 0.02) continue;
    absl::PrintF("  cpu %-16s %6.2f s, %5.2f ms per live scan\n", name, used,
                 1e3 * used / static_cast<double>(ms.size()));
  }
}

int Run(const Settings& settings) {
  const std::vector<Drive> drives = ReadDrives(settings);
  const Drive dense = {{1'700'000'000'000'000'000, MakeDenseScan(settings.points)}};
  const std::string run = absl::StrCat(getpid());
  std::vector<Robot> live, others;
  for (int i = 0; i < settings.robots; ++i) {
    live.push_back({absl::StrCat("live-", run, "-", i), &drives[i % drives.size()],
                    settings.rate_hz, static_cast<double>(i) / settings.robots});
  }
  for (int i = 0; i < settings.dense; ++i) {
    others.push_back({absl::StrCat("dense-", run, "-", i), &dense, settings.rate_hz, 0});
  }
  for (int i = 0; i < settings.backfill; ++i) {
    others.push_back({absl::StrCat("late-", run, "-", i), &drives[i % drives.size()], 0, 0});
  }
  auto client = client::Client::Connect({.address = settings.server}).value();
  int opened = 0;
  for (; opened < settings.empty; ++opened) {
    const auto session =
        client->CreateSession(absl::StrCat("empty-", run, "-", opened), "vlp16").status();
    if (session.ok()) continue;
    absl::PrintF("empty session %d: %s\n", opened, session.ToString());
    break;
  }
  const std::map<std::string, double> before = CpuOf(settings.pid);
  std::atomic<bool> stop = false, stop_others = false;
  const auto begin = SteadyClock::now() + std::chrono::seconds(1);
  std::vector<std::thread> threads, other_threads;
  for (Robot& robot : live) {
    threads.emplace_back([&] { Push(settings, robot, begin, stop); });
  }
  for (Robot& robot : others) {
    other_threads.emplace_back([&] { Push(settings, robot, begin, stop_others); });
  }
  std::this_thread::sleep_until(begin + std::chrono::seconds(settings.seconds));
  Report(settings, "live", live, before);
  if (!others.empty()) Report(settings, "others", others, before);
  std::fflush(stdout);
  std::_Exit(0);  // Whoever is stuck is not waited for.
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) {
  CLI::App app("Load of a fleet on a running server");
  isthmus::bench::Settings settings;
  app.add_option("data", settings.data, "Folder of `isthmus simulate`")->required();
  app.add_option("--server", settings.server, "Address")->capture_default_str();
  app.add_option("--robots", settings.robots, "Robots at the rate")->capture_default_str();
  app.add_option("--rate", settings.rate_hz, "Scans per second of each")->capture_default_str();
  app.add_option("--seconds", settings.seconds, "How long")->capture_default_str();
  app.add_option("--dense", settings.dense, "Robots with dense scans beside them");
  app.add_option("--points", settings.points, "Points of a dense scan")->capture_default_str();
  app.add_option("--backfill", settings.backfill, "Robots that send as fast as they can");
  app.add_option("--empty", settings.empty, "Sessions that send nothing");
  app.add_option("--pid", settings.pid, "Server whose CPU is counted");
  CLI11_PARSE(app, argc, argv);
  return isthmus::bench::Run(settings);
}
