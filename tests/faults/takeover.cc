#include "tests/faults/takeover.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/faults/harness/proxy.h"
#include "tests/faults/harness/server_group.h"
#include "tests/faults/harness/worker_group.h"

namespace isthmus::faults {
namespace {

constexpr double kNoWordS = 120;
constexpr double kPausedLeasesS = 2;  // Beyond the lease.

void SleepUntil(double when_s) {
  std::this_thread::sleep_for(std::chrono::duration<double>(std::max(0.0, when_s - NowS())));
}

class Drill {
 public:
  Drill(const Setup& setup, const TakeoverOptions& options, Report& report)
      : setup_(setup), options_(options), report_(report), random_(setup.seed) {
    const std::string folder = setup.folder + "/takeover";
    std::filesystem::remove_all(folder);
    std::vector<std::string> stores;
    for (int i = 0; i < options.servers; ++i) {
      links_.push_back(std::make_unique<Proxy>(options.socket, setup.seed));
      stores.push_back(
          absl::StrCat("postgresql://isthmus@", links_.back()->address(), "/postgres"));
    }
    group_ = std::make_unique<ServerGroup>(setup.server, folder, stores, options.lease_s);
    group_->AwaitOwner();
    // By links of their own, which nobody cuts.
    workers_ = std::make_unique<WorkerGroup>(
        options.worker_program, folder,
        std::vector<std::string>(static_cast<size_t>(options.workers), setup.store));
    fleet_ = std::make_unique<Fleet>(setup, FleetOptions{.addresses = {group_->addresses()},
                                                         .period_s = options.period_s,
                                                         .spools = folder + "/spools"});
  }

  void Run() {
    fleet_->Drive();
    const double begin_s = NowS();
    for (int fault = 0; fault < options_.faults; ++fault) {
      SleepUntil(begin_s + options_.every_s * (fault + 1));
      if (options_.cut_s > 0 && fault == options_.faults / 2) CutOff();
      const int parts = options_.restarts + 1;
      if (options_.restarts > 0 && fault % (options_.faults / parts) == 1 &&
          restarts_ < options_.restarts) {
        ++restarts_;
        options_.restart_database();
      }
      Harm();
      Heal();
      LookForDurable();
    }
    for (const auto& [server, until_s] : paused_) SleepUntil(until_s);
    SleepUntil(mended_s_);
    Heal();
    if (!fleet_->acks().WaitFor(fleet_->acks().count() + 20, kNoWordS)) {
      report_.Break(absl::StrCat("no acknowledgements for ", kNoWordS, " s"));
    }
  }

  void Conclude() {
    fleet_->Stop();
    fleet_->Finish(report_);
    std::string why;
    if (!workers_->Stop(&why)) report_.Break(why);
    if (!group_->Stop(&why)) report_.Break(why);
    const StoredMap map = ReadStoredMap("", setup_.store);
    CheckAcks(*fleet_, map, report_);
    CheckMap(setup_, fleet_->pushed(), map, report_);
    Figures();
  }

 private:
  // A worker, or a server that is not paused yet.
  void Harm() {
    const int drawn =
        std::uniform_int_distribution<int>(0, options_.servers + options_.workers - 1)(random_);
    if (drawn >= options_.servers) {
      workers_->Kill(drawn - options_.servers);
      ++worker_kills_;
      return;
    }
    std::vector<int> candidates;
    for (int i = 0; i < options_.servers; ++i) {
      if (!paused_.contains(i)) candidates.push_back(i);
    }
    if (candidates.empty()) return;
    const int owner = group_->OwnerNow();
    int victim =
        candidates[std::uniform_int_distribution<size_t>(0, candidates.size() - 1)(random_)];
    if (options_.always_the_owner && owner >= 0) victim = owner;
    const bool is_kill = options_.only_kills || std::bernoulli_distribution(0.5)(random_);
    if (victim == owner && !paused_.contains(owner)) {
      harmed_.emplace_back(is_kill ? "killed" : "paused", NowS());
    }
    group_->Signal(victim, is_kill ? SIGKILL : SIGSTOP);
    ++(is_kill ? kills_ : pauses_);
    if (!is_kill) paused_[victim] = NowS() + options_.lease_s + kPausedLeasesS;
  }

  // Ends the faults that were to last until now.
  void Heal() {
    std::erase_if(paused_, [this](const auto& entry) {
      if (NowS() < entry.second) return false;
      group_->Signal(entry.first, SIGCONT);
      return true;
    });
    if (mended_s_ > 0 && NowS() >= mended_s_) {
      links_[cut_]->Stall(false);
      mended_s_ = 0;
    }
  }

  // The owner, so that it matters.
  void CutOff() {
    const int owner = group_->OwnerNow();
    cut_ = static_cast<size_t>(std::max(owner, 0));
    links_[cut_]->Stall(true);
    if (owner >= 0 && !paused_.contains(owner)) harmed_.emplace_back("cut off", NowS());
    mended_s_ = NowS() + options_.cut_s;
  }

  void LookForDurable() {
    client::ClientOptions options = PatientClient(group_->addresses());
    options.backoff.max_attempts = 1;
    const auto client = client::Client::Connect(options);
    if (!client.ok()) return;  // Between two owners.
    for (const auto& robot : fleet_->robots()) {
      const uint64_t told = robot->durable();
      const auto session = (*client)->GetSession(robot->session());
      if (absl::IsNotFound(session.status())) report_.Break("a session is gone");
      if (session.ok() && session->durable_sequence < told) {
        report_.lost_durable += told - session->durable_sequence;
      }
    }
  }

  // Until any robot was acknowledged by the next owner.
  double WaitAfter(double harmed_s, double owned_s) const {
    double first_s = harmed_s + kNoWordS;
    for (const auto& robot : fleet_->robots()) {
      const std::vector<double> acked = robot->acked_s();
      const auto ack = std::lower_bound(acked.begin(), acked.end(), owned_s);
      if (ack != acked.end()) first_s = std::min(first_s, *ack);
    }
    return first_s - harmed_s;
  }

  void Figures() {
    report_.faults = absl::StrFormat(
        "%d servers, lease %.0f s, %d kills, %d pauses, %d workers, %d of them killed, %d restarts "
        "of PostgreSQL, cut off for %.0f s, %d robots, seed %d",
        options_.servers, options_.lease_s, kills_, pauses_, options_.workers, worker_kills_,
        restarts_, options_.cut_s, setup_.robots, setup_.seed);
    std::string ends;
    for (const auto& [code, count] : group_->ends())
      absl::StrAppend(&ends, " ", count, " with ", code);
    report_.figures.push_back(absl::StrCat("servers ended:", ends));
    const std::vector<ServerGroup::Owner> owners = group_->owners();
    std::map<std::string, std::vector<double>> waits;
    for (const auto& harm : harmed_) {
      const auto next = std::find_if(owners.begin(), owners.end(), [&harm](const auto& owner) {
        return owner.since_s > harm.second;
      });
      if (next != owners.end()) {
        waits[harm.first].push_back(WaitAfter(harm.second, next->since_s));
      }
    }
    if (waits.empty()) report_.Break("no takeover was seen");
    for (auto& [what, seconds] : waits) {
      std::sort(seconds.begin(), seconds.end());
      report_.figures.push_back(
          absl::StrFormat("owner %s, %d times: acknowledged again after p50 %.2f s, max %.2f s",
                          what, seconds.size(), seconds[seconds.size() / 2], seconds.back()));
    }
  }

  const Setup& setup_;
  const TakeoverOptions& options_;
  Report& report_;
  std::mt19937_64 random_;
  std::vector<std::unique_ptr<Proxy>> links_;  // Links of servers to PostgreSQL.
  std::unique_ptr<ServerGroup> group_;
  std::unique_ptr<WorkerGroup> workers_;
  std::unique_ptr<Fleet> fleet_;
  std::vector<std::pair<std::string, double>> harmed_;  // Faults of owners, and when.
  std::map<int, double> paused_;                        // Until when.
  size_t cut_ = 0;
  double mended_s_ = 0;
  int kills_ = 0, pauses_ = 0, worker_kills_ = 0, restarts_ = 0;
};

}  // namespace

Report TakeOver(const Setup& setup, const TakeoverOptions& options) {
  const double begin_s = NowS();
  Report report;
  report.name = "servers with spares";
  Drill drill(setup, options, report);
  drill.Run();
  drill.Conclude();
  report.seconds = NowS() - begin_s;
  return report;
}

}  // namespace isthmus::faults
