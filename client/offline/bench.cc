// isthmus bench: comparisons that others can repeat.
#include <absl/strings/str_cat.h>

#include <cstdio>
#include <optional>

#include "client/console/console.h"
#include "client/console/exit_code.h"
#include "client/console/offline_commands.h"
#include "client/offline/bench_paper.h"
#include "client/offline/bench_report.h"
#include "client/offline/commands.h"
#include "core/io/file_io.h"

namespace isthmus::cli {
namespace {

struct Options {
  PaperBenchOptions bench;
  std::string json;
};

absl::StatusOr<PaperBenchRun> RunWithProgress(const PaperBenchOptions& options,
                                              const std::string& world, const std::string& mode,
                                              uint64_t seed) {
  std::optional<Progress> progress;
  return RunPaperBench(world, mode, seed, options.seconds, [&](int done, int total) {
    if (!progress) progress.emplace(absl::StrCat(world, " ", seed, " ", mode), total);
    progress->Update(done);
  });
}

// Prints what is known as it comes: a bench takes minutes.
void Say(const std::string& lines) {
  std::fputs(lines.c_str(), stdout);
  std::fflush(stdout);
}

int Run(const Options& options) {
  const PaperBenchOptions& bench = options.bench;
  std::vector<PaperBenchRun> runs;
  for (const std::string& world : bench.worlds) {
    for (const uint64_t seed : bench.seeds) {
      for (const std::string& mode : bench.modes) {
        auto run = RunWithProgress(bench, world, mode, seed);
        if (absl::IsInvalidArgument(run.status())) return Fail(kUsage, run.status());
        if (!run.ok()) return Fail(kFailed, run.status());
        Say((runs.empty() ? PaperBenchHeader() : "") + PaperBenchLine(*run));
        runs.push_back(*std::move(run));
      }
    }
  }
  Say(PaperBenchMeans(runs));
  if (options.json.empty()) return kOk;
  const absl::Status written = io::WriteFile(options.json, ToJson(bench, runs).dump(2) + "\n");
  return written.ok() ? kOk : Fail(kFailed, written);
}

}  // namespace

void AddBench(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* bench = AddOfflineCommand(app, "bench");
  bench->require_subcommand(1);
  CLI::App* paper = bench->add_subcommand(
      "paper", "Tables 3 and 4 of the paper: two robots, one odometry or another");
  paper->add_option("--worlds", options->bench.worlds, "museum, campus, ... (see simulate)")
      ->delimiter(',')
      ->capture_default_str();
  paper->add_option("--odometry", options->bench.modes, "aloam, floam, continuous")
      ->delimiter(',')
      ->capture_default_str();
  paper->add_option("--seed", options->bench.seeds, "Of worlds, drives and noise; one or several")
      ->delimiter(',')
      ->capture_default_str();
  paper->add_option("--seconds", options->bench.seconds, "Length of each drive")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  paper->add_option("--json", options->json, "FILE to write everything to");
  paper->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
