// isthmus merge: finished maps and recorded drives of several robots into one, without a server.
#include <absl/strings/str_cat.h>
#include <unistd.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "client/console/console.h"
#include "client/console/exit_code.h"
#include "client/console/interruption.h"
#include "client/console/json.h"
#include "client/console/match_text.h"
#include "client/console/numbers.h"
#include "client/console/offline_commands.h"
#include "client/console/output_name.h"
#include "client/console/push_scans.h"
#include "client/console/recording_options.h"
#include "client/console/say.h"
#include "client/console/waiting.h"
#include "client/offline/commands.h"
#include "client/offline/embedded_server.h"
#include "client/offline/merge/bare_maps.h"
#include "client/offline/merge/drives.h"
#include "client/offline/merge/merge_input.h"
#include "core/geometry/near_origin.h"
#include "core/io/file_io.h"
#include "core/io/output_file.h"
#include "core/records/map_graph.h"
#include "core/records/map_info.h"

namespace isthmus::cli {
namespace {

struct MergeResult {
  std::vector<MergeInput> inputs;  // Without their points.
  MapInfo info;
  MatchGraph graph;     // Pairs without sensor poses as DecideBarePairs reports them.
  std::string output;   // Empty when nothing was merged and so nothing written.
  bool merged = false;  // All of them into one map.
};

// Something was merged, and by verified matches only.
bool IsVerified(const MergeResult& result) {
  return !result.output.empty() &&
         std::none_of(
             result.graph.matches.begin(), result.graph.matches.end(),
             [](const MatchEdge& edge) { return edge.match.reason == MatchReason::kUnverified; });
}

// A pair without sensor poses that --unverified would have joined but for a rival.
bool HasRefused(const MergeResult& result) {
  return std::any_of(result.graph.matches.begin(), result.graph.matches.end(),
                     [&](const MatchEdge& edge) { return IsRefused(edge, result.inputs); });
}

Json RivalsJson(const Match& match) {
  Json rivals = Json::array();
  for (const RivalMatch& rival : match.rivals) {
    rivals.push_back({{"T_a_b", cli::ToJson(rival.T_a_b)}, {"confidence", rival.confidence}});
  }
  return rivals;
}

Json ToJson(const MergeResult& result) {
  Json out = {{"merged", result.merged},
              {"verified", IsVerified(result)},
              {"lacking", WhatIsLacking(result.inputs)},
              {"file", result.output.empty() ? Json(nullptr) : Json(result.output)},
              {"inputs", Json::array()},
              {"pairs", Json::array()},
              {"placements", cli::ToJson(result.graph)["placements"]},
              {"estimation_ms", result.info.estimation_ms},
              {"composition_ms", result.info.composition_ms}};
  for (const MergeInput& input : result.inputs) {
    out["inputs"].push_back(
        {{"file", input.file},
         {"robot", input.robot},
         {"points", input.points},
         {"viewpoints", input.viewpoints},
         {"moved_by", {input.moved_by.x(), input.moved_by.y(), input.moved_by.z()}},
         {"drive", input.is_drive}});
  }
  for (const MatchEdge& edge : result.graph.matches) {
    Json pair = cli::ToJson(edge);
    pair["accepted"] = edge.match.state == MatchState::kAccepted;
    pair["rivals"] = RivalsJson(edge.match);
    out["pairs"].push_back(std::move(pair));
  }
  return out;
}

void PrintText(const MergeResult& result) {
  for (const MergeInput& input : result.inputs) {
    if (input.is_drive) {
      Say("%s: %s, %d scans\n", input.robot, input.file, input.viewpoints);
      continue;
    }
    Say("%s: %s, %d points seen from %s\n", input.robot, input.file, input.points,
        input.viewpoints > 0 ? absl::StrCat(input.viewpoints, " places") : "nobody knows where");
  }
  for (const MatchEdge& edge : result.graph.matches) {
    SayLines("\n" + MatchText(edge, edge.robot_a.value() + " ~ " + edge.robot_b.value()));
  }
  Say("\n");
  for (const std::string& sentence : WhatIsLacking(result.inputs)) Say("%s\n", sentence);
  if (result.output.empty()) {
    Say("not merged: nothing written\n");
    return;
  }
  Say("%s: %s, composed in %.1f ms%s\n", result.output,
      result.merged ? "all in one map" : "only the largest group of those that merged",
      result.info.composition_ms,
      IsVerified(result) ? "" : "; UNVERIFIED: look at it before you trust it");
}

struct MergeOptions {
  std::vector<std::string> files;
  RecordingOptions recording;
  std::string output, report;
  double timeout_s = 3600;
  bool unverified = false, json = false;
};

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
absl::Status Write(client::Client& client, const std::string& output, MergeResult* result) {
  if (result->info.components.empty() || result->info.components[0].robots.size() < 2) {
    return absl::OkStatus();
  }
  ExportRequest request;
  if (OutputExtension(output) == ".ply") request.format = ExportFormat::kPly;
  const auto exported = client.ExportToFile(request, output);
  if (exported.ok()) result->output = output;
  return exported.status();
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
  if (absl::Status status = Write(client, options.output, &result); !status.ok()) return status;
  return result;
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
  const absl::Status usable = io::CheckOutput(options.output);
  if (!usable.ok()) return FailInput(usable);
  const absl::Status alone = absl::InvalidArgumentError(
      "one robot alone: name more files, or several --topic TOPIC=ROBOT");
  if (maps.size() == 1 && recordings.empty()) return Fail(kUsage, alone);
  std::set<std::string> names;
  auto inputs = ReadMergeInputs(maps, names);
  if (!inputs.ok()) return FailInput(inputs.status());
  for (const MergeInput& input : *inputs) {
    if (input.moved_by.isZero()) continue;
    Warn("isthmus: %s\n", ShiftText(input.file, input.moved_by));
  }
  auto drives = OpenDrives(recordings, options.recording, names);
  if (!drives.ok()) return FailInput(drives.status());
  if (inputs->size() + drives->inputs.size() < 2) return Fail(kUsage, alone);
  server::PipelineOptions pipeline;
  pipeline.composition_interval_s = 0;
  const auto server = EmbeddedServer::Start(pipeline);
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
    Warn(
        "isthmus: a pair has two alignments that are as good as each other; neither is believed\n");
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
  command->add_option("-o,--output", options->output, "MERGED.pcd (or .ply)")
      ->check(OutputNamed({".pcd", ".ply"}))
      ->required();
  command->add_flag("--json", options->json, "Every pair, with its reasons, as JSON");
  command->add_option("--report", options->report, "REPORT.json to write the same to");
  command->add_flag("--unverified", options->unverified,
                    "Believe the best alignments of maps without sensor poses; may be wrong");
  command->add_option("--timeout", options->timeout_s, "Seconds to take at most")
      ->check(Positive())
      ->capture_default_str();
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
