// isthmus merge: finished maps and recorded drives of several robots into one, without a server.
#include <absl/strings/str_cat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "client/console/console.h"
#include "client/console/exit_code.h"
#include "client/console/interruption.h"
#include "client/console/json.h"
#include "client/console/numbers.h"
#include "client/console/offline_commands.h"
#include "client/console/output_name.h"
#include "client/console/push_scans.h"
#include "client/console/recording_options.h"
#include "client/console/say.h"
#include "client/console/waiting.h"
#include "client/offline/commands.h"
#include "client/offline/config_option.h"
#include "client/offline/embedded_server.h"
#include "client/offline/merge/bare_maps.h"
#include "client/offline/merge/drives.h"
#include "client/offline/merge/merge_input.h"
#include "client/offline/merge/merge_report.h"
#include "client/offline/merge/merged_files.h"
#include "core/io/file_io.h"

namespace isthmus::cli {
namespace {

struct MergeOptions {
  std::vector<std::string> files;
  RecordingOptions recording;
  MergedFiles written;
  std::string config, report;
  double timeout_s = 3600;
  bool unverified = false, json = false;
};

// A pair without sensor poses that --unverified would have joined but for a rival.
bool HasRefused(const MergeResult& result) {
  return std::any_of(result.graph.matches.begin(), result.graph.matches.end(),
                     [&](const MatchEdge& edge) { return IsRefused(edge, result.inputs); });
}

// The clouds leave `input` as they arrive.
absl::Status Upload(client::Client& client, MergeInput& input) {
  const auto session = client.CreateSession(input.robot, "vlp16");
  if (!session.ok()) return session.status();
  for (size_t i = 0; i < input.submaps.size(); ++i) {
    SubmapUpload& submap = input.submaps[i];
    submap.id = {session->record.id, static_cast<uint32_t>(i)};
    const absl::Status status = client.UploadSubmap(submap);
    if (!status.ok()) {
      return absl::Status(status.code(), absl::StrCat(input.file, ": ", status.message()));
    }
    submap.cloud = {};
  }
  return client.FinishSession(session->record.id).status();
}

absl::Status UploadAll(client::Client& client, std::vector<MergeInput>& inputs) {
  Progress progress("maps", inputs.size());
  for (size_t i = 0; i < inputs.size(); ++i) {
    if (absl::Status status = Upload(client, inputs[i]); !status.ok()) return status;
    progress.Update(i + 1);
  }
  return absl::OkStatus();
}

// Component 0 is the largest: where it is one robot alone, nothing was merged.
absl::Status Write(client::Client& client, const MergedFiles& files, MergeResult* result) {
  if (result->info.components.empty() || result->info.components[0].robots.size() < 2) {
    return absl::OkStatus();
  }
  const absl::Status written = WriteFiles(client, files, result->inputs);
  if (written.ok()) result->files = files;
  return written;
}

absl::StatusOr<MergeResult> Merge(EmbeddedServer& server, std::vector<MergeInput> inputs,
                                  Drives drives, const MergeOptions& options,
                                  PushControl& control) {
  client::Client& client = server.client();
  MergeResult result;
  if (absl::Status status = PushDrives(client, drives, control); !status.ok()) return status;
  if (absl::Status status = UploadAll(client, inputs); !status.ok()) return status;
  result.inputs = std::move(inputs);
  for (MergeInput& drive : drives.inputs) result.inputs.push_back(std::move(drive));
  auto info = Wait(client, WaitFor::kSettled, options.timeout_s);
  if (!info.ok()) return info.status();
  auto pairs = DecideBarePairs(client, server.GetMatchGraph(), result.inputs, options.unverified);
  if (!pairs.ok()) return pairs.status();
  info = Wait(client, WaitFor::kSettled, options.timeout_s);
  if (!info.ok()) return info.status();
  result.info = *std::move(info);
  auto graph = client.GetMatchGraph();
  if (!graph.ok()) return graph.status();
  result.graph = *std::move(graph);
  result.graph.matches = *std::move(pairs);
  result.merged = IsMerged(result.info);
  if (absl::Status status = Write(client, options.written, &result); !status.ok()) return status;
  return result;
}

// InvalidArgument for a file that is named twice, and for one to write that is also read.
absl::Status CheckNames(const MergeOptions& options) {
  const auto place_of = [](const std::string& file) {
    std::error_code error;
    return std::filesystem::weakly_canonical(file, error);
  };
  std::set<std::filesystem::path> read;
  for (const std::string& file : options.files) {
    if (read.insert(place_of(file)).second) continue;
    return absl::InvalidArgumentError(absl::StrCat(file, " is named twice"));
  }
  for (const std::string& file : {options.written.map, options.written.picture, options.report}) {
    if (file.empty() || !read.contains(place_of(file))) continue;
    return absl::InvalidArgumentError(
        absl::StrCat(file, " is one of the files to merge: name another one to write"));
  }
  return absl::OkStatus();
}

int Run(const MergeOptions& options) {
  PushControl control;
  const Interruption interruption([&control] {
    if (!control.Stop()) _exit(kInterrupted);
  });
  std::vector<std::string> maps, recordings;
  for (const std::string& file : options.files) {
    (IsDrive(file) ? recordings : maps).push_back(file);
  }
  if (const absl::Status names = CheckNames(options); !names.ok()) return Fail(kUsage, names);
  auto config = LoadConfig(options.config);
  if (!config.ok()) return FailInput(config.status());
  const absl::Status usable = PrepareFiles(options.written);
  if (!usable.ok()) return FailInput(usable);
  const absl::Status alone = absl::InvalidArgumentError(
      "there is only one robot: give more files, or several --topic TOPIC=ROBOT");
  if (maps.size() == 1 && recordings.empty()) return Fail(kUsage, alone);
  std::set<std::string> names;
  auto inputs = ReadMergeInputs(maps, names);
  if (!inputs.ok()) return FailInput(inputs.status());
  for (const MergeInput& input : *inputs) {
    for (const std::string& note : input.notes) Warn("isthmus: %s\n", note);
  }
  auto drives = OpenDrives(recordings, options.recording, names);
  if (!drives.ok()) return FailInput(drives.status());
  if (inputs->size() + drives->inputs.size() < 2) return Fail(kUsage, alone);
  config->pipeline.composition_interval_s = 0;
  const auto server = EmbeddedServer::Start(config->pipeline);
  if (!server.ok()) return Fail(kFailed, server.status());
  const auto result = Merge(**server, *std::move(inputs), *std::move(drives), options, control);
  if (absl::IsDeadlineExceeded(result.status())) return Fail(kNoAnswer, result.status());
  if (absl::IsCancelled(result.status())) return Fail(kInterrupted, result.status());
  if (absl::IsInvalidArgument(result.status())) return FailInput(result.status());
  if (!result.ok()) return Fail(kFailed, result.status());
  if (options.json) {
    cli::Print(ToJson(*result));
  } else {
    PrintText(*result);
  }
  if (!options.report.empty()) {
    const absl::Status written = io::WriteFile(options.report, cli::Text(ToJson(*result)));
    if (!written.ok()) return Fail(kFailed, written);
  }
  if (HasRefused(*result)) {
    Warn("isthmus: a pair has two equally good alignments; neither is accepted\n");
    return kRival;
  }
  return result->merged ? kOk : kNoAnswer;
}

}  // namespace

void AddMerge(CLI::App& app, Action& action) {
  auto options = std::make_shared<MergeOptions>();
  CLI::App* command = AddOfflineCommand(app, "merge");
  command
      ->add_option("FILES", options->files,
                   "Finished maps (.pcd, .ply, .las, .csv), one per robot, and recordings of "
                   "drives (folders "
                   "of scans, .bag, .mcap, .db3, .pcap)")
      ->required()
      ->expected(1, 1000);
  AddRecordingOptions(*command, options->recording);
  command->add_option("-o,--output", options->written.map, "MERGED.pcd (or .ply)")
      ->check(OutputNamed({".pcd", ".ply"}))
      ->required();
  command->add_option("--trajectories", options->written.trajectories,
                      "Folder for a TUM file of each drive, ROBOT.tum, in the merged map's frame");
  command
      ->add_option("--picture", options->written.picture,
                   "FILE.png of the merged map from above, with the drives' trajectories")
      ->check(OutputNamed({".png"}));
  AddConfigOption(*command, options->config);
  command->add_flag("--json", options->json, "Print every pair with its reasons as JSON");
  command->add_option("--report", options->report, "REPORT.json for the same");
  command->add_flag("--unverified", options->unverified,
                    "Accept the best alignments of maps without sensor poses; they may be wrong");
  command->add_option("--timeout", options->timeout_s, "Longest run, seconds")
      ->check(Positive())
      ->capture_default_str();
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
