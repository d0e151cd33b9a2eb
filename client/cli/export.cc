// isthmus export: the merged map as a file.
#include <absl/strings/str_format.h>

#include <map>

#include "client/cli/commands.h"
#include "client/console/console.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"

namespace isthmus::cli {
namespace {

const std::map<std::string, ExportFormat> kFormats = {
    {"pcd", ExportFormat::kPcdBinaryCompressed},
    {"pcd-compressed", ExportFormat::kPcdBinaryCompressed},
    {"pcd-binary", ExportFormat::kPcdBinary},
    {"pcd-ascii", ExportFormat::kPcdAscii},
    {"ply", ExportFormat::kPly},
    {"bt", ExportFormat::kOctoMapBinary},
    {"ot", ExportFormat::kOctoMapFull}};

struct ExportOptions {
  ServerOptions server;
  std::string format, output;
  ExportRequest request;
  bool json = false;
};

int Run(const ExportOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  absl::StatusOr<client::ExportSummary> summary;
  {
    Progress progress(options.output, 0);
    summary = (*client)->ExportToFile(options.request, options.output,
                                      [&](uint64_t bytes) { progress.Update(bytes); });
  }
  if (!summary.ok()) return FailServer(summary.status());
  if (options.json) {
    Print({{"file", options.output},
           {"revision", summary->revision},
           {"size", summary->size},
           {"crc32c", absl::StrFormat("%08x", summary->crc32c)}});
  } else {
    absl::PrintF("%s: %s, revision %d, crc32c %08x\n", options.output, HumanBytes(summary->size),
                 summary->revision, summary->crc32c);
  }
  return kOk;
}

}  // namespace

void AddExport(CLI::App& app, Action& action) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* command = app.add_subcommand("export", "The merged map as PCD, PLY or OctoMap");
  AddServerOptions(*command, options->server);
  command
      ->add_option("--format", options->format,
                   "pcd (compressed), pcd-binary, pcd-ascii, ply, bt (OctoMap: free, occupied, "
                   "unknown), ot (OctoMap with log-odds)")
      ->check(CLI::IsMember(&kFormats))
      ->required();
  command->add_option("--component", options->request.component, "0 is the largest")
      ->capture_default_str();
  command
      ->add_option("--resolution", options->request.resolution_m,
                   "Metres: thinning of clouds (0: as composed), leaf size of OctoMaps (0: 0.2)")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("-o,--output", options->output, "FILE")->required();
  command->add_flag("--json", options->json, "Summary as JSON");
  command->callback([options, &action] {
    options->request.format = kFormats.at(options->format);
    action = [options] { return Run(*options); };
  });
}

}  // namespace isthmus::cli
