// The price of matching by workers: the same pairs of recorded maps matched in one process without
// a board, and by one to four isthmus-worker processes; see BENCHMARK.md.
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "bench/cpu_clock.h"
#include "client/simulation/simulator.h"
#include "core/codec/payload_builder.h"
#include "server/jobs/job_runner.h"
#include "server/pipeline.h"
#include "storage/postgresql/postgres_store.h"
#include "storage/postgresql/worker_store.h"
#include "tests/storage/postgresql/postgres_server.h"

namespace isthmus::bench {
namespace {

using server::JobRunner;
using server::MapOfJob;
using server::PairJob;

struct Settings {
  std::string world = "museum";
  int robots = 6;
  double seconds = 120;
  uint64_t seed = 1;
  int workers = 4;  // From one to so many.
};

template <typename T>
T OrThrow(absl::StatusOr<T> value) {
  if (!value.ok()) throw std::runtime_error(value.status().ToString());
  return *std::move(value);
}

void OrThrow(const absl::Status& status) {
  if (!status.ok()) throw std::runtime_error(status.ToString());
}

// Drives the robots one after the other; their submaps are in the store then. What the server
// matches meanwhile is of no account.
void Record(const Settings& settings, const std::string& url) {
  simulation::Options world;
  world.world = settings.world;
  world.robots = settings.robots;
  world.seconds = settings.seconds;
  world.seed = settings.seed;
  const auto simulator = OrThrow(simulation::Simulator::Create(world));
  server::PipelineOptions options;
  options.loops.enabled = false;
  options.revisits.retire = false;
  const auto pipeline =
      OrThrow(server::Pipeline::Open(options, OrThrow(storage::OpenPostgresStore(url, ""))));
  for (int robot = 0; robot < settings.robots; ++robot) {
    const SessionRequest request{RobotId(absl::StrCat("robot-", robot)), "vlp16"};
    const SessionId session = OrThrow(pipeline->CreateSession(request)).record.id;
    for (int i = 0; i < simulator->scan_count(); ++i) {
      const Scan scan = simulator->MakeScan(robot, i);
      OrThrow(pipeline->SubmitScan(session,
                                   {scan.sequence, scan.end_stamp_ns, codec::MakePayload(scan)}));
    }
    OrThrow(pipeline->FinishSession(session).status());
  }
}

std::vector<PairJob> MakeJobs(const storage::MapStore& store) {
  std::vector<MapOfJob> maps;
  for (const SessionRecord& session : OrThrow(store.ListSessions())) {
    MapOfJob& map = maps.emplace_back();
    map.session = session.id;
    for (const SubmapInfo& submap : OrThrow(store.ListSubmaps(session.id))) {
      map.submaps.push_back(submap.id.index);
      map.stamps_ns.push_back(submap.first_stamp_ns);
      map.T_odom_submap.push_back(submap.T_odom_submap);
    }
  }
  std::vector<PairJob> jobs;
  for (size_t a = 0; a < maps.size(); ++a) {
    for (size_t b = a + 1; b < maps.size(); ++b) {
      PairJob& job = jobs.emplace_back();
      job.a = maps[a];
      job.b = maps[b];
      job.search = true;
    }
  }
  return jobs;
}

// But for the time that its stages took.
std::string BytesOf(Match match) {
  for (StageTime& stage : match.stages) stage.ms = 0;
  return server::EncodeMatch(match);
}

using Results = std::map<std::string, std::string>;  // By key.

std::string KeyOf(const PairJob& job) {
  return absl::StrCat(job.a.session.value(), " ", job.b.session.value());
}

// CPU seconds of it.
double MatchHere(const std::string& url, const std::vector<PairJob>& jobs, Results* results) {
  const auto store = OrThrow(storage::OpenWorkerStore(url, ""));
  JobRunner runner(store.get(), {});
  const CpuClock cpu(CpuClock::Of::kProcess);
  for (const PairJob& job : jobs) (*results)[KeyOf(job)] = BytesOf(OrThrow(runner.Run(job, {})));
  return 1e-3 * cpu.Ms();
}

pid_t Hire(const std::string& url) {
  const pid_t child = fork();
  if (child != 0) return child;
  execl(ISTHMUS_WORKER, ISTHMUS_WORKER, "--store", url.c_str(), "--log-level", "off", nullptr);
  _exit(127);
}

struct Measured {
  double wall_s = 0;  // From the first job posted, with workers waiting, to the last result.
  double cpu_s = 0;   // Of the workers, from their start to their end.
  bool are_same = true;
};

Measured MatchByWorkers(const std::string& url, const std::vector<PairJob>& jobs, int workers,
                        const Results& expected, storage::JobBoard* board) {
  std::vector<pid_t> hired(workers);
  for (pid_t& worker : hired) worker = Hire(url);
  constexpr std::chrono::milliseconds kLook{20};
  while (OrThrow(board->CountWorkers()) < workers) std::this_thread::sleep_for(kLook);
  Measured measured;
  const auto begin = std::chrono::steady_clock::now();
  for (const PairJob& job : jobs) OrThrow(board->Post({KeyOf(job), EncodePairJob(job)}));
  size_t ended = 0;
  while (ended < jobs.size()) {
    std::this_thread::sleep_for(kLook);
    const std::vector<storage::EndedJob> done = OrThrow(board->ListEnded());
    for (const storage::EndedJob& job : done) {
      if (!job.problem.empty()) throw std::runtime_error(job.problem);
      const std::string result = BytesOf(OrThrow(server::DecodeMatch(job.result)));
      measured.are_same = measured.are_same && result == expected.at(job.key);
    }
    OrThrow(board->Remove(done));
    ended += done.size();
  }
  measured.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  for (const pid_t worker : hired) {
    kill(worker, SIGTERM);
    rusage usage = {};
    int status = 0;
    if (wait4(worker, &status, 0, &usage) != worker || status != 0) {
      throw std::runtime_error("a worker ended ill");
    }
    for (const timeval& time : {usage.ru_utime, usage.ru_stime}) {
      measured.cpu_s += static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    }
  }
  return measured;
}

void Benchmark(const Settings& settings) {
  const auto database = storage::PostgresServer::Start();
  if (database == nullptr) throw std::runtime_error("PostgreSQL does not start");
  Record(settings, database->url());
  const auto store = OrThrow(storage::OpenPostgresStore(database->url(), ""));
  const std::vector<PairJob> jobs = MakeJobs(*store);
  Results expected;
  MatchHere(database->url(), jobs, &expected);  // Leaves in the store what it makes of submaps.
  std::printf("%zu pairs of %s, seed %d\n\n", jobs.size(), settings.world.c_str(),
              static_cast<int>(settings.seed));
  std::printf(
      "| workers | CPU time (s) | without a board (s) | efficiency | wall (s) | cores busy | same "
      "bits |\n");
  std::printf("|---|---|---|---|---|---|---|\n");
  for (int workers = 1; workers <= settings.workers; ++workers) {
    // Anew each time: what a core does in a second changes within minutes where others share it.
    const double here_s = MatchHere(database->url(), jobs, &expected);
    const Measured measured =
        MatchByWorkers(database->url(), jobs, workers, expected, store->jobs());
    std::printf("| %d | %.1f | %.1f | %.3f | %.1f | %.2f | %s |\n", workers, measured.cpu_s, here_s,
                here_s / measured.cpu_s, measured.wall_s, measured.cpu_s / measured.wall_s,
                measured.are_same ? "yes" : "NO");
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) {
  isthmus::bench::Settings settings;
  CLI::App app("Matches pairs of recorded maps without and by isthmus-worker processes.",
               "workers_benchmark");
  app.add_option("--world", settings.world, "As of isthmus simulate")->capture_default_str();
  app.add_option("--robots", settings.robots, "All pairs of them are matched")
      ->check(CLI::Range(2, 40))
      ->capture_default_str();
  app.add_option("--seconds", settings.seconds, "That each drives")->capture_default_str();
  app.add_option("--seed", settings.seed, "Of the world and the drives")->capture_default_str();
  app.add_option("--workers", settings.workers, "From one to so many")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    isthmus::bench::Benchmark(settings);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "workers_benchmark: %s\n", error.what());
    return 1;
  }
}
