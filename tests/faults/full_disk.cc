#include "tests/faults/full_disk.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <random>
#include <stdexcept>
#include <thread>

namespace isthmus::faults {
namespace {

constexpr double kStuckS = 60;
// The log of the server has room, a submap has not.
constexpr uint64_t kFullBytes = 16 * 1024;

bool WaitUntil(double timeout_s, const std::function<bool()>& holds) {
  const double deadline_s = NowS() + timeout_s;
  while (!holds()) {
    if (NowS() > deadline_s) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

class Filler {
 public:
  Filler(const Setup& setup, const FullDiskOptions& options, const ServerProcess& server,
         const Fleet& fleet, Report& report)
      : options_(options), server_(server), fleet_(fleet), report_(report), random_(setup.seed) {
    auto client = client::Client::Connect(PatientClient(server.address()));
    if (!client.ok()) throw std::runtime_error(client.status().ToString());
    client_ = *std::move(client);
  }

  void Run() {
    for (int time = 0; time < options_.times && report_.broken.empty(); ++time) {
      const uint64_t acks = std::uniform_int_distribution<uint64_t>(1, options_.max_acks)(random_);
      if (!fleet_.acks().WaitFor(fleet_.acks().count() + acks, kStuckS)) {
        return report_.Break("no acknowledgements");
      }
      server_.LimitFiles(kFullBytes);
      WhileFull();
      server_.LimitFiles(std::nullopt);
      Recover();
    }
    report_.figures.push_back(absl::StrFormat("storing again within %.2f s of space", longest_s_));
  }

 private:
  std::string Problem() {
    const auto info = client_->GetMapInfo();
    if (!info.ok()) {
      report_.Break(absl::StrCat("GetMapInfo: ", info.status().ToString()));
      return "?";
    }
    return info->storage_problem;
  }

  std::vector<uint64_t> Durable() const {
    std::vector<uint64_t> durable;
    for (const auto& robot : fleet_.robots()) {
      const auto session = client_->GetSession(robot->session());
      durable.push_back(session.ok() ? session->durable_sequence : 0);
    }
    return durable;
  }

  void WhileFull() {
    if (!WaitUntil(kStuckS, [&] { return !Problem().empty(); })) {
      return report_.Break("the server does not say that its disk is full");
    }
    const std::vector<uint64_t> before = Durable();
    std::this_thread::sleep_for(std::chrono::duration<double>(options_.full_s));
    if (Durable() != before) report_.Break("scans became durable on a full disk");
    uint64_t points = 0;
    const absl::Status read = client_->QueryRegion({}, [&](const RegionChunk& chunk) {
      points += chunk.points.size();
      return true;
    });
    if (!read.ok()) report_.Break(absl::StrCat("readers: ", read.ToString()));
    if (!client_->ListSubmaps().ok()) report_.Break("readers: no submaps");
  }

  void Recover() {
    const double since_s = NowS();
    if (!WaitUntil(kStuckS, [&] { return Problem().empty(); })) {
      return report_.Break(absl::StrCat("still: ", Problem()));
    }
    longest_s_ = std::max(longest_s_, NowS() - since_s);
  }

  const FullDiskOptions options_;
  const ServerProcess& server_;
  const Fleet& fleet_;
  Report& report_;
  std::mt19937_64 random_;
  std::unique_ptr<client::Client> client_;
  double longest_s_ = 0;
};

}  // namespace

Report FillDisk(const Setup& setup, const FullDiskOptions& options) {
  const double begin_s = NowS();
  Report report;
  report.name = "full disk";
  report.faults = absl::StrFormat("%d times full for %.0f s, %d robots, seed %d", options.times,
                                  options.full_s, setup.robots, setup.seed);
  const auto server = NewServer(setup, "full_disk");
  // A robot without a spool gives up a server that refuses its scans.
  Fleet fleet(setup,
              {.addresses = {server->address()}, .period_s = 0.1, .spools = server->folder()});
  fleet.Drive();
  Filler(setup, options, *server, fleet, report).Run();
  Conclude(setup, *server, fleet, report);
  report.seconds = NowS() - begin_s;
  return report;
}

}  // namespace isthmus::faults
