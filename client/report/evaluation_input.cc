#include "client/report/evaluation_input.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "client/console/numbers.h"
#include "client/readers/folder/times_file.h"
#include "core/formats/kitti_poses.h"
#include "core/formats/tum.h"
#include "core/io/file_io.h"

namespace isthmus::report {
namespace {

using evaluation::TrajectoryPair;

// A file's poses; without stamps where it has none and no times were given.
struct PoseFile {
  Trajectory poses;
  bool has_stamps = true;
};

absl::Status Named(const std::string& path, const absl::Status& status) {
  return absl::Status(status.code(), absl::StrCat(path, ": ", status.message()));
}

absl::StatusOr<PoseFile> ReadKitti(const std::string& path, const std::string& text,
                                   const std::string& times) {
  const auto poses = formats::ParseKittiPoses(text);
  if (!poses.ok()) return Named(path, poses.status());
  PoseFile file;
  file.has_stamps = !times.empty();
  std::vector<int64_t> stamps;
  if (file.has_stamps) {
    const auto lines = io::ReadFile(times);
    if (!lines.ok()) return lines.status();
    auto parsed = readers::ParseTimes(*lines);
    if (!parsed.ok()) return Named(times, parsed.status());
    stamps = *std::move(parsed);
    if (stamps.size() != poses->size()) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "%s has %d times, but %s has %d poses; give the times of these poses, one per line",
          times, stamps.size(), path, poses->size()));
    }
  }
  file.poses.reserve(poses->size());
  for (size_t i = 0; i < poses->size(); ++i) {
    file.poses.push_back(
        {file.has_stamps ? stamps[i] : static_cast<int64_t>(i) * 1'000'000'000, (*poses)[i]});
  }
  return file;
}

absl::StatusOr<PoseFile> ReadPoses(const std::string& path, const std::string& times) {
  const auto text = io::ReadFile(path);
  if (!text.ok()) return text.status();
  if (formats::LooksLikeKittiPoses(*text)) return ReadKitti(path, *text, times);
  auto poses = formats::ParseTum(*text);
  if (!poses.ok()) return Named(path, poses.status());
  return PoseFile{*std::move(poses), true};
}

const std::string& OneOrEach(const std::vector<std::string>& files, size_t i) {
  static const std::string kNone;
  if (files.empty()) return kNone;
  return files[files.size() == 1 ? 0 : i];
}

absl::StatusOr<TrajectoryPair> ReadPair(const EvaluationInput& input, size_t i) {
  const std::string& truth_path = OneOrEach(input.truths, i);
  const std::string& times = OneOrEach(input.times, i);
  auto truth = ReadPoses(truth_path, times);
  if (!truth.ok()) return truth.status();
  auto estimate = ReadPoses(input.estimates[i], times);
  if (!estimate.ok()) return estimate.status();
  const bool by_line =
      !truth->has_stamps && !estimate->has_stamps && truth->poses.size() == estimate->poses.size();
  if (!by_line && !(truth->has_stamps && estimate->has_stamps)) {
    return absl::InvalidArgumentError(absl::StrCat(
        truth->has_stamps ? input.estimates[i] : truth_path,
        " is a KITTI file without stamps; give its times.txt with --times (only two KITTI files "
        "of as many poses are compared line by line)"));
  }
  return TrajectoryPair{"", std::move(truth->poses), std::move(estimate->poses)};
}

// The names of the files; where they are alike, with the folders they lie in.
std::vector<std::string> NamesOf(const std::vector<std::string>& estimates) {
  std::vector<std::string> names;
  names.reserve(estimates.size());
  for (const std::string& file : estimates) names.push_back(std::filesystem::path(file).stem());
  const std::vector<std::string> stems = names;
  for (size_t i = 0; i < names.size(); ++i) {
    if (std::count(stems.begin(), stems.end(), stems[i]) == 1) continue;
    const std::filesystem::path folder =
        std::filesystem::absolute(estimates[i]).parent_path().filename();
    names[i] = (folder / stems[i]).string();
  }
  return names;
}

}  // namespace

void AddEvaluationOptions(CLI::App& command, EvaluationInput& input) {
  command.add_option("--truth", input.truths,
                     "FILE ..., TUM or KITTI poses; one per estimate, or one for all");
  command.add_option("--estimate", input.estimates, "FILE ..., likewise");
  command.add_option("--times", input.times,
                     "times.txt of KITTI poses, seconds; one per estimate, or one for all");
  command.add_option("--names", input.names,
                     "Names of the estimates; without it their files' names");
  command.add_flag("--merged", input.options.merged,
                   "The estimates are in one frame: align all of them together");
  command
      .add_option("--align", input.align,
                  "rigid: least squares, no scale; first: the first poses coincide; none: as they "
                  "are")
      ->check(CLI::IsMember({"rigid", "first", "none"}))
      ->capture_default_str();
  command
      .add_option("--tolerance", input.options.tolerance_s,
                  "Seconds between stamps that belong together, at most")
      ->check(cli::Positive())
      ->capture_default_str();
  command.add_option("--delta", input.delta, "Relative errors over this many ...")
      ->check(cli::Positive())
      ->capture_default_str();
  command.add_option("--delta-unit", input.delta_unit, "... metres, seconds or frames")
      ->check(CLI::IsMember({"m", "s", "frames"}))
      ->capture_default_str();
}

absl::Status CheckEvaluationInput(const EvaluationInput& input) {
  const size_t count = input.estimates.size();
  if (input.truths.empty() || count == 0) {
    return absl::InvalidArgumentError("give --truth FILE ... and --estimate FILE ...");
  }
  if (input.truths.size() != count && input.truths.size() != 1) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%d --truth for %d --estimate: give one truth per estimate, in the same "
                        "order, or one for all",
                        input.truths.size(), count));
  }
  if (input.times.size() > 1 && input.times.size() != count) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%d --times for %d --estimate: give one per estimate, or one for all",
                        input.times.size(), count));
  }
  if (!input.names.empty() && input.names.size() != count) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%d --names for %d --estimate: name each", input.names.size(), count));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<TrajectoryPair>> ReadEvaluationPairs(const EvaluationInput& input) {
  const std::vector<std::string> names =
      input.names.empty() ? NamesOf(input.estimates) : input.names;
  std::vector<TrajectoryPair> pairs;
  for (size_t i = 0; i < input.estimates.size(); ++i) {
    auto pair = ReadPair(input, i);
    if (!pair.ok()) return pair.status();
    pair->name = names[i];
    pairs.push_back(*std::move(pair));
  }
  return pairs;
}

absl::StatusOr<bool> IsCameraFrame(const EvaluationInput& input) {
  for (const std::string& truth : input.truths) {
    const auto text = io::ReadFile(truth);
    if (!text.ok()) return text.status();
    if (!formats::LooksLikeKittiPoses(*text)) return false;
  }
  return true;
}

evaluation::EvaluationOptions OptionsOf(const EvaluationInput& input) {
  using evaluation::Alignment;
  using evaluation::DeltaUnit;
  evaluation::EvaluationOptions options = input.options;
  options.alignment = input.align == "none"    ? Alignment::kNone
                      : input.align == "first" ? Alignment::kFirstPose
                                               : Alignment::kRigid;
  options.delta = {input.delta, input.delta_unit == "s"        ? DeltaUnit::kSeconds
                                : input.delta_unit == "frames" ? DeltaUnit::kFrames
                                                               : DeltaUnit::kMetres};
  return options;
}

}  // namespace isthmus::report
