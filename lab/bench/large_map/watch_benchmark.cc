// The time until clients that watch the map have a submap that has come. See
// lab/docs/large_map.md.
#include <absl/strings/str_format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "client/library/client.h"
#include "client/library/map_mirror.h"
#include "core/concurrency/mutex.h"
#include "core/stopwatch.h"
#include "lab/bench/large_map/city.h"
#include "lab/bench/merging/temporary_folder.h"
#include "server/pipeline.h"
#include "server/rpc/server.h"
#include "storage/sqlite/sqlite_store.h"

namespace isthmus::bench {
namespace {

struct Arguments {
  int robots = 2, submaps = 60;
  double pause_s = 1;  // Between two submaps of all robots, on average; they come at random.
  unsigned seed = 1;
};

// When the watcher was told of a submap, and when it held the points of the map with it.
struct Seen {
  double told_ms = -1, held_ms = -1;
};

// Two that watch, each over a connection of its own: one is told what changes, one holds the map.
class Watchers {
 public:
  Watchers(const std::string& address, const Stopwatch& watch) : watch_(watch) {
    teller_ = *client::Client::Connect({.address = address});
    holder_ = *client::Client::Connect({.address = address});
    telling_ = std::thread([this] {
      (void)teller_->WatchMap({}, 0, [this](const MapStep& step) {
        for (const SubmapPlace& place : step.submaps) Note(place.submap, &Seen::told_ms);
        return !stopped_;
      });
    });
    holding_ = std::thread([this] {
      client::MapMirror mirror(holder_.get());
      (void)mirror.Follow([this](const client::MapMirror& now) {
        for (const auto& [id, place] : now.submaps()) Note(id, &Seen::held_ms);
        return !stopped_;
      });
    });
  }
  ~Watchers() {
    telling_.join();
    holding_.join();
  }

  // They end with the next map.
  void Stop() { stopped_ = true; }
  std::map<SubmapId, Seen> seen() const {
    MutexLock lock(&mutex_);
    return seen_;
  }

 private:
  void Note(const SubmapId& id, double Seen::*when) {
    MutexLock lock(&mutex_);
    double& ms = seen_[id].*when;
    if (ms < 0) ms = watch_.Ms();
  }

  const Stopwatch& watch_;
  std::unique_ptr<client::Client> teller_, holder_;
  std::atomic<bool> stopped_ = false;
  mutable Mutex mutex_;
  std::map<SubmapId, Seen> seen_ ABSL_GUARDED_BY(mutex_);
  std::thread telling_, holding_;
};

void Report(const char* what, std::vector<double> ms) {
  std::sort(ms.begin(), ms.end());
  const auto quantile = [&](double share) {
    return ms[static_cast<size_t>(share * static_cast<double>(ms.size() - 1))];
  };
  absl::PrintF("%-28s p50 %.0f p90 %.0f p99 %.0f max %.0f ms\n", what, quantile(.5), quantile(.9),
               quantile(.99), ms.back());
}

absl::Status Run(const Arguments& arguments) {
  const TemporaryFolder folder;
  auto store = storage::OpenSqliteStore(folder.path());
  if (!store.ok()) return store.status();
  auto pipeline = server::Pipeline::Open({}, *std::move(store));
  if (!pipeline.ok()) return pipeline.status();
  rpc::ServerOptions listen;
  listen.listen = "127.0.0.1:0";
  auto server = rpc::RpcServer::Start(pipeline->get(), listen);
  if (!server.ok()) return server.status();
  const City city({.points = 4'000});
  std::mt19937 rng(arguments.seed);
  std::vector<SessionId> sessions;
  for (int i = 0; i < arguments.robots; ++i) {
    const auto opened = (*pipeline)->sessions().Create(
        {.robot = RobotId(absl::StrFormat("robot_%d", i)), .sensor = "hdl64"});
    if (!opened.ok()) return opened.status();
    sessions.push_back(opened->record.id);
  }
  const Stopwatch watch;
  Watchers watchers((*server)->address(), watch);
  std::map<SubmapId, double> stored_ms;
  std::exponential_distribution<double> pause_s(1 / arguments.pause_s);
  double points = 0;
  for (int i = 0; i < arguments.submaps; ++i) {
    const size_t robot = static_cast<size_t>(i) % sessions.size();
    const auto index = static_cast<uint32_t>(static_cast<size_t>(i) / sessions.size());
    // Streets apart: whether they match is not what is measured.
    Submap submap = city.Drive(index * city.submap_length_m(), robot % 2 == 0 ? -3 : 3, &rng);
    submap.id = {sessions[robot], index};
    submap.robot = RobotId(absl::StrFormat("robot_%d", robot));
    points += static_cast<double>(submap.points.size());
    std::this_thread::sleep_for(std::chrono::duration<double>(pause_s(rng)));
    const SubmapId id = submap.id;
    const auto added = (*pipeline)->sessions().AddSubmap(std::move(submap));
    if (!added.ok()) return added.status();
    stored_ms[id] = watch.Ms();
  }
  (*pipeline)->WaitUntilIdle();
  std::this_thread::sleep_for(std::chrono::seconds(2));
  const std::map<SubmapId, Seen> seen = watchers.seen();
  watchers.Stop();
  server->reset();  // Ends their streams.
  std::vector<double> told, held;
  for (const auto& [id, at_ms] : stored_ms) {
    const auto found = seen.find(id);
    if (found == seen.end() || found->second.held_ms < 0) {
      return absl::InternalError("a submap was not told of");
    }
    told.push_back(found->second.told_ms - at_ms);
    held.push_back(found->second.held_ms - at_ms);
  }
  absl::PrintF("%d submaps of %.0f points on average\n", arguments.submaps,
               points / arguments.submaps);
  Report("stored to told", std::move(told));
  Report("stored to points held", std::move(held));
  return absl::OkStatus();
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) {
  isthmus::bench::Arguments arguments;
  CLI::App app("From a submap that is stored to those who watch the map, over a socket.");
  app.add_option("--robots", arguments.robots)->capture_default_str();
  app.add_option("--submaps", arguments.submaps, "Of all robots")->capture_default_str();
  app.add_option("--pause", arguments.pause_s, "Seconds from one to the next, on average")
      ->capture_default_str();
  app.add_option("--seed", arguments.seed)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = isthmus::bench::Run(arguments);
  if (status.ok()) return 0;
  std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return 1;
}
