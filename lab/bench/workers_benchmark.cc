// The price of matching by workers: the same pairs of recorded maps matched by isthmus-worker
// processes, by as many processes that have them dealt out, and by one; see
// lab/docs/workers.md.
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
#include "core/codec/payload_builder.h"
#include "fleet/postgresql/postgres_store.h"
#include "fleet/postgresql/worker_store.h"
#include "lab/simulation/simulator.h"
#include "server/jobs/job_runner.h"
#include "server/pipeline.h"
#include "tests/fleet/postgresql/postgres_server.h"

namespace isthmus::bench {
namespace {

using server::JobMapInput;
using server::JobRunner;
using server::PairJob;

struct Settings {
  std::string world = "museum";
  int robots = 6;
  double seconds = 120;
  uint64_t seed = 1;
  int workers = 4;  // From one to so many.
  // For a process that has its pairs dealt out: the recorded maps, its number, and how many there
  // are.
  std::string store = {};
  int share = 0, of = 1;
};

template <typename T>
T OrThrow(absl::StatusOr<T> value) {
  if (!value.ok()) throw std::runtime_error(value.status().ToString());
  return *std::move(value);
}

void OrThrow(const absl::Status& status) {
  if (!status.ok()) throw std::runtime_error(status.ToString());
}

// Drives the robots one after the other; their submaps are in the store then. The server's own
// matches meanwhile do not count.
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
    const SessionId session = OrThrow(pipeline->sessions().Create(request)).record.id;
    for (int i = 0; i < simulator->scan_count(); ++i) {
      const Scan scan = simulator->MakeScan(robot, i);
      OrThrow(pipeline->sessions().SubmitScan(
          session, {scan.sequence, scan.end_stamp_ns, codec::MakePayload(scan)}));
    }
    OrThrow(pipeline->sessions().Finish(session).status());
  }
}

std::vector<PairJob> MakeJobs(const storage::MapStore& store) {
  std::vector<JobMapInput> maps;
  for (const SessionRecord& session : OrThrow(store.ListSessions())) {
    JobMapInput& map = maps.emplace_back();
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
std::string BytesOf(server::PairResult result) {
  for (StageTime& stage : result.match.stages) stage.ms = 0;
  return server::EncodeResult(result);
}

using Results = std::map<std::string, std::string>;  // By key.

std::string KeyOf(const PairJob& job) {
  return absl::StrCat(job.a.session.value(), " ", job.b.session.value());
}

void MatchShare(const Settings& settings, Results* results) {
  const auto store = OrThrow(storage::OpenWorkerStore(settings.store, ""));
  JobRunner runner(store.get(), {});
  const std::vector<PairJob> jobs = MakeJobs(*store);
  for (size_t i = settings.share; i < jobs.size(); i += settings.of) {
    (*results)[KeyOf(jobs[i])] = BytesOf(OrThrow(runner.Run(jobs[i], {})));
  }
}

pid_t Start(const std::vector<std::string>& command) {
  std::vector<char*> arguments;
  arguments.reserve(command.size() + 1);
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t child = fork();
  if (child != 0) return child;
  execv(arguments.front(), arguments.data());
  _exit(127);
}

// Waits for their end; CPU seconds that they took.
double CpuSecondsOf(const std::vector<pid_t>& processes) {
  double cpu_s = 0;
  for (const pid_t process : processes) {
    rusage usage = {};
    int status = 0;
    if (wait4(process, &status, 0, &usage) != process || status != 0) {
      throw std::runtime_error("a process ended ill");
    }
    for (const timeval& time : {usage.ru_utime, usage.ru_stime}) {
      cpu_s += static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    }
  }
  return cpu_s;
}

// CPU seconds without a queue.
double MatchDealtOut(const std::string& url, int processes) {
  std::vector<pid_t> started;
  started.reserve(processes);
  for (int i = 0; i < processes; ++i) {
    started.push_back(Start({"/proc/self/exe", "--store", url, "--share", absl::StrCat(i), "--of",
                             absl::StrCat(processes)}));
  }
  return CpuSecondsOf(started);
}

struct Measured {
  double wall_s = 0;  // From the first job posted, with workers waiting, to the last result.
  double cpu_s = 0;   // The workers', from their start to their end.
  bool are_same = true;
};

Measured MatchByWorkers(const std::string& url, const std::vector<PairJob>& jobs, int workers,
                        const Results& expected, storage::JobQueue* queue) {
  std::vector<pid_t> hired(workers);
  for (pid_t& worker : hired) {
    worker = Start({ISTHMUS_WORKER, "--store", url, "--log-level", "off"});
  }
  constexpr std::chrono::milliseconds kLook{20};
  while (OrThrow(queue->CountWorkers()).able < workers) std::this_thread::sleep_for(kLook);
  Measured measured;
  const auto begin = std::chrono::steady_clock::now();
  for (const PairJob& job : jobs) OrThrow(queue->Post({KeyOf(job), EncodeJob(job)}));
  size_t ended = 0;
  while (ended < jobs.size()) {
    std::this_thread::sleep_for(kLook);
    const std::vector<storage::EndedJob> done = OrThrow(queue->ListEnded());
    for (const storage::EndedJob& job : done) {
      if (!job.problem.empty()) throw std::runtime_error(job.problem);
      const std::string result = BytesOf(std::get<server::PairResult>(
          OrThrow(server::DecodeResult(server::MatchKey{}, job.result))));
      measured.are_same = measured.are_same && result == expected.at(job.key);
    }
    OrThrow(queue->Remove(done));
    ended += done.size();
  }
  measured.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  for (const pid_t worker : hired) kill(worker, SIGTERM);
  measured.cpu_s = CpuSecondsOf(hired);
  return measured;
}

void Benchmark(Settings settings) {
  const auto database = storage::PostgresServer::Start();
  if (database == nullptr) throw std::runtime_error("PostgreSQL does not start");
  settings.store = database->url();
  Record(settings, settings.store);
  const auto store = OrThrow(storage::OpenPostgresStore(settings.store, ""));
  const std::vector<PairJob> jobs = MakeJobs(*store);
  Results expected;
  MatchShare(settings, &expected);  // Leaves in the store what it makes of submaps.
  std::printf("%zu pairs of %s, seed %d\n\n", jobs.size(), settings.world.c_str(),
              static_cast<int>(settings.seed));
  std::printf(
      "| workers | CPU time (s) | dealt out to as many (s) | to one (s) | efficiency | of one | "
      "wall (s) | cores busy | same bits |\n|---|---|---|---|---|---|---|---|---|\n");
  for (int workers = 1; workers <= settings.workers; ++workers) {
    // Anew each time: what a core does in a second changes within minutes where others share it.
    const double one_s = MatchDealtOut(settings.store, 1);
    const double dealt_s = workers == 1 ? one_s : MatchDealtOut(settings.store, workers);
    const Measured measured =
        MatchByWorkers(settings.store, jobs, workers, expected, store->jobs());
    std::printf("| %d | %.1f | %.1f | %.1f | %.3f | %.3f | %.1f | %.2f | %s |\n", workers,
                measured.cpu_s, dealt_s, one_s, dealt_s / measured.cpu_s, one_s / measured.cpu_s,
                measured.wall_s, measured.cpu_s / measured.wall_s,
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
  const auto store = app.add_option(
      "--store", settings.store,
      "Only match a share of the pairs of what was recorded there, as this program has it done");
  app.add_option("--share", settings.share, "Which, from 0 on")->needs(store);
  app.add_option("--of", settings.of, "How many shares")->needs(store)->check(CLI::Range(1, 64));
  CLI11_PARSE(app, argc, argv);
  try {
    if (store->count() > 0) {
      isthmus::bench::Results unused;
      isthmus::bench::MatchShare(settings, &unused);
    } else {
      isthmus::bench::Benchmark(settings);
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "workers_benchmark: %s\n", error.what());
    return 1;
  }
}
