// isthmus eval: estimated trajectories against the truth, by the errors that people quote.
#include <cstdio>
#include <utility>

#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/offline_commands.h"
#include "client/evaluation/evaluation.h"
#include "client/report/evaluation_figures.h"
#include "client/report/evaluation_input.h"
#include "client/report/evaluation_tables.h"
#include "client/report/figures.h"
#include "client/report/timing_file.h"
#include "lab/commands/commands.h"

namespace isthmus::cli {
namespace {

struct EvalOptions {
  report::EvaluationInput input;
  std::string format = "text";
  bool json = false;
  std::string figures;
  std::vector<std::string> timing;
};

void PrintTables(const evaluation::Evaluation& evaluation, report::TableFormat format) {
  std::string out;
  for (const report::Table& table : report::TablesOf(evaluation)) {
    out += report::Format(table, format) + "\n";
  }
  for (const std::string& sentence : report::MethodOf(evaluation)) {
    out += report::FormatParagraph(sentence, format);
    if (format != report::TableFormat::kText) out += "\n";
  }
  std::fputs(out.c_str(), stdout);
}

// True if the --timing file is at fault; later failures are not the input's fault.
bool IsInputFault(const absl::Status& status) {
  return absl::IsInvalidArgument(status) || absl::IsNotFound(status);
}

absl::Status Draw(const evaluation::Evaluation& evaluation, const EvalOptions& options) {
  std::vector<report::TimingFile> timing;
  for (const std::string& path : options.timing) {
    auto file = report::ReadTimingFile(path);
    if (!file.ok()) return file.status();
    timing.push_back(*std::move(file));
  }
  const auto camera_frame = report::IsCameraFrame(options.input);
  if (!camera_frame.ok()) return camera_frame.status();
  return report::DrawFigures(options.figures, report::FiguresOf(evaluation, *camera_frame, timing));
}

int Run(const EvalOptions& options) {
  if (const absl::Status usage = report::CheckEvaluationInput(options.input); !usage.ok()) {
    return Fail(kUsage, usage);
  }
  const auto pairs = report::ReadEvaluationPairs(options.input);
  if (!pairs.ok()) return FailInput(pairs.status());
  const auto evaluation = evaluation::Evaluate(*pairs, report::OptionsOf(options.input));
  if (!evaluation.ok()) return FailInput(evaluation.status());
  if (options.json || options.format == "json") {
    Print(report::JsonOf(*evaluation));
  } else {
    PrintTables(*evaluation, report::ParseTableFormat(options.format));
  }
  if (options.figures.empty()) return kOk;
  const absl::Status drawn = Draw(*evaluation, options);
  return drawn.ok() ? kOk : Fail(IsInputFault(drawn) ? kInput : kFailed, drawn);
}

}  // namespace

void AddEval(CLI::App& app, Action& action) {
  auto options = std::make_shared<EvalOptions>();
  CLI::App* command = AddOfflineCommand(app, "eval");
  report::AddEvaluationOptions(*command, options->input);
  command->get_option("--truth")->required();
  command->get_option("--estimate")->required();
  command->add_option("--format", options->format, "Format of the tables")
      ->check(CLI::IsMember({"text", "markdown", "latex", "json"}))
      ->capture_default_str();
  command->add_flag("--json", options->json, "As --format json");
  command->add_option("--figures", options->figures,
                      "DIR for figures as SVG and PNG; drawn by Matplotlib");
  command
      ->add_option("--timing", options->timing,
                   "FILE.csv ... from isthmus odometry --timing: a figure of the time per stage")
      ->needs("--figures");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
