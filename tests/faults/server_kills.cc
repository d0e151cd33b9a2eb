#include "tests/faults/server_kills.h"

#include <absl/strings/str_cat.h>

#include <chrono>
#include <random>
#include <thread>

namespace isthmus::faults {
namespace {

constexpr double kSilenceS = 60;

class Killer {
 public:
  Killer(const Setup& setup, const ServerKillOptions& options, ServerProcess& server, Fleet& fleet,
         Report& report)
      : options_(options), server_(server), fleet_(fleet), report_(report), random_(setup.seed) {}

  void Run() {
    for (int kill = 0; kill < options_.kills && server_.is_running(); ++kill) {
      if (!WaitForMoment()) return;
      server_.Kill();
      if (kill % options_.startup_every == 0) KillAtStart();
      Restart();
    }
  }

 private:
  void Delay(int max_us) {
    std::this_thread::sleep_for(
        std::chrono::microseconds(std::uniform_int_distribution<int>(0, max_us)(random_)));
  }

  // After some acknowledgements, and a little more.
  bool WaitForMoment() {
    const uint64_t acks = std::uniform_int_distribution<uint64_t>(0, options_.max_acks)(random_);
    if (!fleet_.acks().WaitFor(fleet_.acks().count() + acks, kSilenceS)) {
      report_.Break(absl::StrCat("no acknowledgements for ", kSilenceS, " s: ", server_.Log()));
      return false;
    }
    Delay(20'000);
    return true;
  }

  void KillAtStart() {
    server_.Launch();
    Delay(200'000);
    server_.Kill();
  }

  // Durable scans are looked up before any robot can send them again.
  void Restart() {
    server_.Launch();
    if (!server_.WaitUntilUp()) return report_.Break(absl::StrCat("no restart: ", server_.Log()));
    report_.lost_durable += LostDurable(fleet_.robots(), server_.own_address(), report_);
    server_.Publish();
  }

  const ServerKillOptions options_;
  ServerProcess& server_;
  Fleet& fleet_;
  Report& report_;
  std::mt19937_64 random_;
};

}  // namespace

Report KillServer(const Setup& setup, const ServerKillOptions& options) {
  const double begin_s = NowS();
  Report report;
  report.name = "kill -9 of the server";
  report.faults =
      absl::StrCat(options.kills, " kills, ", setup.robots, " robots, seed ", setup.seed);
  const auto server = NewServer(setup, "server_kills");
  Fleet fleet(setup, {.addresses = {server->address()}});
  fleet.Drive();
  Killer(setup, options, *server, fleet, report).Run();
  Conclude(setup, *server, fleet, report);
  report.seconds = NowS() - begin_s;
  return report;
}

}  // namespace isthmus::faults
