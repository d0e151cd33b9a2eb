#include "tests/faults/link_faults.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <chrono>
#include <random>
#include <thread>

#include "tests/faults/harness/proxy.h"

namespace isthmus::faults {
namespace {

constexpr double kBackFillS = 120;
constexpr double kLiveS = 0.5;
constexpr double kMaxFirstPoseS = 2;  // After the link's return.

void Sleep(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

class Spoiler {
 public:
  Spoiler(const Setup& setup, const LinkFaultOptions& options, const Fleet& fleet,
          const std::vector<std::unique_ptr<Proxy>>& links, Report& report)
      : options_(options), fleet_(fleet), links_(links), report_(report), random_(setup.seed) {}

  void Run() {
    for (int i = 0; i < options_.resets; ++i) {
      Sleep(std::uniform_real_distribution<>(0.01, 0.3)(random_));
      for (const auto& link : links_) link->Reset(0.1);
    }
    Hold("stall", options_.stall_s, [](Proxy& link, bool on) { link.Stall(on); });
    Hold("slow link", options_.slow_s,
         [this](Proxy& link, bool on) { link.SetRate(on ? options_.slow_bytes_per_s : 0); });
    Hold("outage", options_.outage_s, [](Proxy& link, bool on) { link.Cut(on); });
    Hold("dark outage", options_.outage_s, [](Proxy& link, bool on) {
      link.Stall(on);
      if (!on) link.Reset(1);
    });
    if (!options_.half_open) return;
    for (const auto& link : links_) link->Forget();
    Recover("half-open", NowS(), false);
  }

 private:
  template <typename Switch>
  void Hold(const char* name, double seconds, const Switch& turn) {
    if (seconds <= 0) return;
    for (const auto& link : links_) turn(*link, true);
    Sleep(seconds);
    for (const auto& link : links_) turn(*link, false);
    Recover(name, NowS(), true);
  }

  // The times from `since_s` until the first pose comes, until the first one of a scan that is
  // hardly older than itself, and until nothing is left to be sent again; each for the slowest
  // robot.
  void Recover(const char* name, double since_s, bool is_prompt) {
    double first_s = 0, live_s = 0, done_s = 0;
    for (const auto& robot : fleet_.robots()) {
      const uint64_t behind = robot->pushed();
      while (!IsLive(*robot, behind, since_s)) {
        if (NowS() > since_s + kBackFillS) {
          return report_.Break(absl::StrCat(name, ": back-fill not done after ", kBackFillS, " s"));
        }
        Sleep(0.005);
      }
      const std::vector<double> acked = robot->acked_s();
      const auto first = std::lower_bound(acked.begin(), acked.end(), since_s);
      first_s = std::max(first_s, *first - since_s);
      live_s = std::max(live_s, acked[FirstLive(*robot, since_s)] - since_s);
      done_s = std::max(done_s, acked[behind - 1] - since_s);
    }
    report_.figures.push_back(absl::StrFormat(
        "%s: first pose after %.2f s, back-fill done after %.2f s, live after %.2f s", name,
        first_s, std::max(0.0, done_s), live_s));
    if (is_prompt && first_s > kMaxFirstPoseS) {
      report_.Break(absl::StrFormat("%s: first pose only after %.1f s", name, first_s));
    }
  }

  // The index of the first acknowledgement after `since_s` that came within kLiveS of its scan; the
  // number of acknowledgements if none did.
  static size_t FirstLive(const Robot& robot, double since_s) {
    const std::vector<double> acked = robot.acked_s(), pushed = robot.pushed_s();
    size_t i =
        static_cast<size_t>(std::lower_bound(acked.begin(), acked.end(), since_s) - acked.begin());
    while (i < acked.size() && i < pushed.size() && acked[i] > pushed[i] + kLiveS) ++i;
    return i;
  }

  static bool IsLive(const Robot& robot, uint64_t behind, double since_s) {
    const size_t acked = robot.acked_s().size();
    return acked >= behind && FirstLive(robot, since_s) < acked;
  }

  const LinkFaultOptions options_;
  const Fleet& fleet_;
  const std::vector<std::unique_ptr<Proxy>>& links_;
  Report& report_;
  std::mt19937_64 random_;
};

}  // namespace

Report SpoilLinks(const Setup& setup, const LinkFaultOptions& options) {
  const double begin_s = NowS();
  Report report;
  report.name = "bad links";
  const auto server = NewServer(setup, "links");
  std::vector<std::unique_ptr<Proxy>> links;
  std::vector<std::string> addresses;
  for (int i = 0; i < setup.robots; ++i) {
    links.push_back(std::make_unique<Proxy>(server->folder() + "/robots",
                                            setup.seed + static_cast<uint64_t>(i)));
    addresses.push_back(links.back()->address());
  }
  FleetOptions fleet_options;
  fleet_options.addresses = addresses;
  fleet_options.period_s = options.period_s;
  fleet_options.spools = server->folder() + "/spools";
  Fleet fleet(setup, fleet_options);
  fleet.Drive();
  Spoiler(setup, options, fleet, links, report).Run();
  Conclude(setup, *server, fleet, report);
  int64_t resets = 0;
  for (const auto& link : links) resets += link->resets();
  report.faults = absl::StrFormat(
      "%d robots, %d resets, stall %.0f s, %.0f kB/s for %.0f s, "
      "2 outages of %.0f s%s, seed %d",
      setup.robots, resets, options.stall_s, options.slow_bytes_per_s / 1000, options.slow_s,
      options.outage_s, options.half_open ? ", half-open" : "", setup.seed);
  report.seconds = NowS() - begin_s;
  return report;
}

}  // namespace isthmus::faults
