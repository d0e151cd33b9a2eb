// isthmus report: one HTML page of a server, or of trajectories against the truth.
#include <absl/strings/str_cat.h>
#include <stdlib.h>

#include <filesystem>
#include <utility>

#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/output_name.h"
#include "client/console/say.h"
#include "client/report/evaluation_figures.h"
#include "client/report/evaluation_input.h"
#include "client/report/evaluation_page.h"
#include "client/report/figures.h"
#include "client/report/server_page.h"
#include "core/io/file_io.h"

namespace isthmus::cli {
namespace {

namespace fs = std::filesystem;

struct ReportOptions {
  ServerOptions server;
  report::EvaluationInput input;
  std::vector<std::string> timing;
  std::string output, figures;
  bool no_figures = false;
};

// The folder of the figures: the one that was named, else one that goes with the command.
class FigureFolder {
 public:
  static absl::StatusOr<FigureFolder> Create(const std::string& named) {
    if (!named.empty()) return FigureFolder(named, false);
    std::string path = (fs::temp_directory_path() / "isthmus_report_XXXXXX").string();
    if (mkdtemp(path.data()) == nullptr) return io::FileError("create folder", path, errno);
    return FigureFolder(path, true);
  }
  FigureFolder(FigureFolder&& other) noexcept
      : path_(std::move(other.path_)), is_temporary_(std::exchange(other.is_temporary_, false)) {}
  FigureFolder& operator=(FigureFolder&&) = delete;
  ~FigureFolder() {
    std::error_code ignored;
    if (is_temporary_) fs::remove_all(path_, ignored);
  }
  const std::string& path() const { return path_; }

 private:
  FigureFolder(std::string path, bool is_temporary)
      : path_(std::move(path)), is_temporary_(is_temporary) {}
  std::string path_;
  bool is_temporary_;
};

int WritePage(const absl::StatusOr<std::string>& page, const ReportOptions& options) {
  if (!page.ok()) return Fail(kFailed, page.status());
  const absl::Status written = io::WriteFile(options.output, *page);
  if (!written.ok()) return Fail(kFailed, written);
  Say("%s: open it in a browser\n", options.output);
  return kOk;
}

int FailDrawing(const absl::Status& status) {
  return Fail(kFailed,
              absl::Status(status.code(),
                           absl::StrCat(status.message(), "; --no-figures works without it")));
}

int RunServer(const ReportOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto state = report::ReadServerState(**client, !options.no_figures);
  if (!state.ok()) return FailServer(state.status());
  if (options.no_figures) return WritePage(report::ServerPage(*state, {}, ""), options);
  const auto folder = FigureFolder::Create(options.figures);
  if (!folder.ok()) return Fail(kFailed, folder.status());
  const auto figures = report::FiguresOf(*state, folder->path());
  if (!figures.ok()) return Fail(kFailed, figures.status());
  const absl::Status drawn = report::DrawFigures(folder->path(), *figures);
  if (!drawn.ok()) return FailDrawing(drawn);
  return WritePage(report::ServerPage(*state, *figures, folder->path()), options);
}

// The figures of trajectories; errors are the input's.
absl::StatusOr<std::vector<report::Figure>> RunFigures(const evaluation::Evaluation& evaluation,
                                                       const ReportOptions& options) {
  const auto camera_frame = report::IsCameraFrame(options.input);
  if (!camera_frame.ok()) return camera_frame.status();
  std::vector<report::TimingFile> timing;
  for (const std::string& path : options.timing) {
    auto file = report::ReadTimingFile(path);
    if (!file.ok()) return file.status();
    timing.push_back(*std::move(file));
  }
  return report::FiguresOf(evaluation, *camera_frame, timing);
}

int RunTrajectories(const ReportOptions& options) {
  if (const absl::Status usage = report::CheckEvaluationInput(options.input); !usage.ok()) {
    return Fail(kUsage, usage);
  }
  const auto pairs = report::ReadEvaluationPairs(options.input);
  if (!pairs.ok()) return FailInput(pairs.status());
  const auto evaluation = evaluation::Evaluate(*pairs, report::OptionsOf(options.input));
  if (!evaluation.ok()) return FailInput(evaluation.status());
  if (options.no_figures) return WritePage(report::EvaluationPage(*evaluation, {}, ""), options);
  const auto figures = RunFigures(*evaluation, options);
  if (!figures.ok()) return FailInput(figures.status());
  const auto folder = FigureFolder::Create(options.figures);
  if (!folder.ok()) return Fail(kFailed, folder.status());
  const absl::Status drawn = report::DrawFigures(folder->path(), *figures);
  if (!drawn.ok()) return FailDrawing(drawn);
  return WritePage(report::EvaluationPage(*evaluation, *figures, folder->path()), options);
}

}  // namespace

void AddReport(CLI::App& app, Action& action) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* command = app.add_subcommand(
      "report", "An HTML page about a server, or about trajectories against the truth");
  AddServerOptions(*command, options->server);
  report::AddEvaluationOptions(*command, options->input);
  command->add_option("--timing", options->timing,
                      "FILE.csv ... from isthmus odometry --timing, with --truth");
  command->add_option("-o,--output", options->output, "FILE.html")
      ->check(OutputNamed({".html", ".htm"}))
      ->required();
  command->add_option("--figures", options->figures, "DIR for the page's figures as SVG and PNG");
  command->add_flag("--no-figures", options->no_figures, "Tables only; needs no Matplotlib");
  command->callback([options, &action] {
    const bool is_run = !options->input.truths.empty() || !options->input.estimates.empty();
    action = [options, is_run] { return is_run ? RunTrajectories(*options) : RunServer(*options); };
  });
}

}  // namespace isthmus::cli
