// isthmus-worker: takes work off the servers of sites that are kept in PostgreSQL.
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <random>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "core/concurrency/event_count.h"
#include "core/concurrency/thread_role.h"
#include "core/site_name.h"
#include "fleet/postgresql/postgres_store.h"
#include "fleet/postgresql/postgresql.h"
#include "fleet/worker/site_worker.h"
#include "server/jobs/limits.h"
#include "server/main/log.h"
#include "server/main/program.h"
#include "server/main/stop_signal.h"

namespace isthmus::server {
namespace {

// Exit codes beside kUsage, as docs/api.md promises them.
enum ExitCode { kStopped = 0, kStore = 3 };

// Between two looks at sites that have no jobs, a question of less than a millisecond each; and
// between attempts to reach one that cannot be worked for now.
constexpr std::chrono::milliseconds kLookForJobs{250}, kTryAgain{2000};
// Time between two looks for an end of the work by itself.
constexpr std::chrono::milliseconds kTick{100};

struct Arguments {
  std::string store;
  std::vector<std::string> sites = {kDefaultSite};
  int cache_mb = 256;
  LogOptions log;
};

// "robots-1/4711/3f2a": no other process has it, though process numbers come again.
std::string NameOfThis() {
  char host[256] = "";
  gethostname(host, sizeof(host) - 1);
  return absl::StrCat(host, "/", getpid(), "/", absl::Hex(std::random_device()()));
}

// A site, and the last word on it: why it waits; empty while it is at work.
struct Site {
  std::string name;
  std::unique_ptr<SiteWorker> worker = nullptr;
  std::optional<std::string> trouble = {};

  // Says it once.
  void Note(const absl::Status& status) {
    const std::string now = status.ok() ? "" : std::string(status.message());
    if (now == trouble) return;
    if (now.empty()) {
      Log(spdlog::level::info, "at work", LogFields{.site = name});
    } else {
      Log(spdlog::level::warn, absl::StrCat("waits: ", now), LogFields{.site = name});
    }
    trouble = now;
  }
};

class Worker {
 public:
  explicit Worker(const Arguments& arguments) : store_(arguments.store), me_(NameOfThis()) {
    const size_t bytes = (static_cast<size_t>(arguments.cache_mb) << 20) / arguments.sites.size();
    options_ = {.submap_cache_bytes = bytes / 3, .prepared_bytes = bytes - bytes / 3};
    for (const std::string& name : arguments.sites) sites_.push_back({name});
  }

  // Until `stop`; an error that waiting does not mend ends it before.
  absl::Status Run(std::stop_token stop) {
    const std::stop_callback wake(stop, [this] { stopped_.Notify(); });
    while (!stop.stop_requested()) {
      bool did_some = false, all_open = true;
      for (Site& site : sites_) {
        const absl::Status status = Serve(site, stop, &did_some);
        if (absl::IsFailedPrecondition(status) || absl::IsInvalidArgument(status)) return status;
        site.Note(status);
        all_open = all_open && status.ok();
      }
      if (did_some) continue;
      stopped_.WaitPast(0, absl::Now() + absl::FromChrono(all_open ? kLookForJobs : kTryAgain));
    }
    return absl::OkStatus();
  }

 private:
  absl::Status Serve(Site& site, const std::stop_token& stop, bool* did_some) {
    if (site.worker == nullptr) {
      auto worker = SiteWorker::Open(store_, site.name, me_, options_);
      if (!worker.ok()) return worker.status();
      site.worker = *std::move(worker);
      site.Note(absl::OkStatus());
    }
    const auto done = site.worker->RunOne(stop);
    if (!done.ok()) {
      // Jobs that were lost with the way are taken by others. A worker that cannot read the map is
      // none to count with until it has opened it anew; one that owes a result has to bring it
      // first.
      if (!site.worker->owes()) site.worker.reset();
      return absl::UnavailableError(done.status().message());
    }
    if (!*done) return absl::OkStatus();
    *did_some = true;
    const SiteWorker::Done& job = **done;
    const std::optional<JobKey> key = ParseJobKey(job.key);
    const std::string name = key ? Describe(*key) : job.key;
    if (job.status.ok()) {
      Log(spdlog::level::info, absl::StrFormat("%s: %.2f s", name, job.seconds),
          LogFields{.site = site.name});
    } else {
      Log(absl::IsCancelled(job.status) ? spdlog::level::info : spdlog::level::warn,
          absl::StrCat(name, ": ", job.status.message()), LogFields{.site = site.name});
    }
    return absl::OkStatus();
  }

  const std::string store_, me_;
  JobRunner::Options options_;
  std::vector<Site> sites_;
  EventCount stopped_;
};

// The code to exit with where the program is to end here.
std::optional<int> Parse(int argc, char** argv, Arguments& arguments) {
  CLI::App app(
      "Matches, compares and searches robots' maps for servers whose maps are in PostgreSQL. Start "
      "one per spare core, on any machine that reaches the database.",
      "isthmus-worker");
  app.set_version_flag("--version", "isthmus-worker " ISTHMUS_VERSION);
  app.add_option("--store", arguments.store,
                 "The servers' PostgreSQL database, postgresql://USER@HOST/DATABASE")
      ->required();
  app.add_option("--site", arguments.sites, "Sites to work for, several or one (default: default)");
  app.add_option("--cache-mb", arguments.cache_mb, "Memory for prepared maps, about this much")
      ->check(CLI::Range(16, 1 << 20))
      ->capture_default_str();
  AddLogOptions(app, arguments.log);
  return ParseArguments(app, argc, argv);
}

int Run(const Arguments& arguments, StopSignal& signal) {
  if (absl::Status status = storage::CheckPostgresUrl(arguments.store); !status.ok()) {
    return Fail(kUsage, status);
  }
  for (const std::string& site : arguments.sites) {
    if (absl::Status status = storage::CheckSite(site); !status.ok()) return Fail(kUsage, status);
  }
  std::stop_source stop;
  std::atomic<bool> has_ended = false;
  absl::Status status;
  std::jthread working([&] {
    // On their machine servers and database come first, or leases are lost to matching.
    LowerPriority(kMatchingNice);
    status = Worker(arguments).Run(stop.get_token());
    has_ended = true;
  });
  std::optional<std::string> name;
  while (!name && !has_ended) name = signal.WaitFor(kTick, OnHangup);
  if (name) spdlog::info("{} received: the present job is given back", *name);
  stop.request_stop();
  working.join();
  return status.ok() ? kStopped : Fail(kStore, status);
}

}  // namespace
}  // namespace isthmus::server

int main(int argc, char** argv) {
  isthmus::server::StopSignal signal;
  isthmus::server::Arguments arguments;
  const std::optional<int> code = isthmus::server::Parse(argc, argv, arguments);
  if (code) return *code;
  return isthmus::server::RunProgram("isthmus-worker", arguments.log, isthmus::server::kStore,
                                     [&] { return isthmus::server::Run(arguments, signal); });
}
