// isthmus eval: estimated trajectories against the truth, by the paper's eq. 3.
#include <absl/strings/str_format.h>

#include <filesystem>
#include <optional>

#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/offline_commands.h"
#include "client/evaluation/trajectory_error.h"
#include "client/offline/commands.h"
#include "client/offline/error_json.h"
#include "core/formats/tum.h"

namespace isthmus::cli {
namespace {

using evaluation::Alignment;
using evaluation::ErrorStatistics;
using evaluation::TrajectoryPair;

struct EvalOptions {
  std::vector<std::string> truths, estimates;
  bool merged = false;
  std::string align = "rigid";
  double tolerance_s = 0.02;
  bool json = false;
};

// One row of the answer.
struct EvalRow {
  std::string name;
  ErrorStatistics errors;
};

struct Evaluation {
  std::vector<EvalRow> robots;         // Each aligned by itself, or all by one alignment if merged.
  std::optional<ErrorStatistics> all;  // If merged.
};

absl::StatusOr<std::vector<TrajectoryPair>> ReadPairs(const EvalOptions& options) {
  std::vector<TrajectoryPair> pairs;
  for (size_t i = 0; i < options.truths.size(); ++i) {
    auto truth = formats::ReadTum(options.truths[i]);
    if (!truth.ok()) return truth.status();
    auto estimate = formats::ReadTum(options.estimates[i]);
    if (!estimate.ok()) return estimate.status();
    pairs.push_back({std::filesystem::path(options.estimates[i]).stem(), *std::move(truth),
                     *std::move(estimate)});
  }
  return pairs;
}

absl::StatusOr<Evaluation> Evaluate(const std::vector<TrajectoryPair>& pairs,
                                    const EvalOptions& options) {
  const Alignment alignment = options.align == "none"    ? Alignment::kNone
                              : options.align == "first" ? Alignment::kFirstPose
                                                         : Alignment::kRigid;
  Evaluation out;
  if (options.merged) {
    auto errors = evaluation::CompareTrajectories(pairs, alignment, options.tolerance_s);
    if (!errors.ok()) return errors.status();
    for (size_t i = 0; i < pairs.size(); ++i) {
      out.robots.push_back({pairs[i].name, errors->robots[i]});
    }
    out.all = errors->all;
    return out;
  }
  for (const TrajectoryPair& pair : pairs) {
    auto errors = evaluation::CompareTrajectories({pair}, alignment, options.tolerance_s);
    if (!errors.ok()) return errors.status();
    out.robots.push_back({pair.name, errors->all});
  }
  return out;
}

void Report(const Evaluation& evaluation, const EvalOptions& options) {
  if (options.json) {
    Json out = {{"alignment", options.align}, {"robots", Json::array()}};
    for (const EvalRow& row : evaluation.robots) {
      Json robot = {{"name", row.name}};
      robot.update(cli::ToJson(row.errors));
      out["robots"].push_back(std::move(robot));
    }
    out["merged"] = evaluation.all ? cli::ToJson(*evaluation.all) : Json(nullptr);
    Print(out);
    return;
  }
  absl::PrintF("%-24s %7s %9s %9s %9s %9s %12s\n", "", "poses", "rmse m", "mean m", "median m",
               "max m", "rotation deg");
  std::vector<EvalRow> rows = evaluation.robots;
  if (evaluation.all) rows.push_back({"all in one frame", *evaluation.all});
  for (const EvalRow& row : rows) {
    const ErrorStatistics& e = row.errors;
    absl::PrintF("%-24s %7d %9.4f %9.4f %9.4f %9.4f %12.3f\n", row.name, e.count, e.rmse_m,
                 e.mean_m, e.median_m, e.max_m, e.rotation_rmse_deg);
  }
}

int Run(const EvalOptions& options) {
  if (options.truths.size() != options.estimates.size()) {
    return Fail(kUsage, absl::InvalidArgumentError(absl::StrFormat(
                            "%d --truth for %d --estimate: give one truth per estimate, in the "
                            "same order",
                            options.truths.size(), options.estimates.size())));
  }
  const auto pairs = ReadPairs(options);
  if (!pairs.ok()) return FailInput(pairs.status());
  const auto evaluation = Evaluate(*pairs, options);
  if (!evaluation.ok()) return FailInput(evaluation.status());
  Report(*evaluation, options);
  return kOk;
}

}  // namespace

void AddEval(CLI::App& app, Action& action) {
  auto options = std::make_shared<EvalOptions>();
  CLI::App* command = AddOfflineCommand(app, "eval");
  command->add_option("--truth", options->truths, "FILE.tum ..., one per estimate")->required();
  command->add_option("--estimate", options->estimates, "FILE.tum ...")->required();
  command->add_flag("--merged", options->merged,
                    "The estimates are in one frame: align all of them together");
  command
      ->add_option("--align", options->align,
                   "rigid: least squares; first: the first poses coincide; none: as they are")
      ->check(CLI::IsMember({"rigid", "first", "none"}))
      ->capture_default_str();
  command
      ->add_option("--tolerance", options->tolerance_s,
                   "Seconds between stamps that belong together")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
