#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <memory>
#include <utility>

#include "client/readers/recording.h"
#include "client/readers/started_reader.h"
#include "core/codec/scan_decoder.h"
#include "core/io/file_io.h"
#include "lab/bench/scenarios.h"

namespace isthmus::bench {
namespace {

// Rows of KITTI: the upper three rows of the matrix, row by row.
absl::StatusOr<std::vector<Pose>> ReadPoses(const std::string& path) {
  const auto text = io::ReadFile(path);
  if (!text.ok()) return text.status();
  std::vector<Pose> poses;
  for (const auto& line : absl::StrSplit(*text, '\n', absl::SkipWhitespace())) {
    std::vector<double> row;
    for (const auto& word : absl::StrSplit(line, absl::ByAnyChar(" \t\r"), absl::SkipEmpty())) {
      if (double value = 0; absl::SimpleAtod(word, &value)) row.push_back(value);
    }
    if (row.size() != 12) {
      return absl::InvalidArgumentError(
          absl::StrCat(path, ": line ", poses.size() + 1, " has ", row.size(), " numbers, not 12"));
    }
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    for (int i = 0; i < 12; ++i) matrix(i / 4, i % 4) = row[i];
    poses.push_back(Pose::FromMatrix(matrix));
  }
  return poses;
}

}  // namespace

absl::StatusOr<Drive> RecordedDrive(const std::string& path, const std::string& poses) {
  const auto recording = readers::OpenRecording(path);
  if (!recording.ok()) return recording.status();
  auto reader = (*recording)->OpenScans(0, {});
  if (!reader.ok()) return reader.status();
  auto truth = ReadPoses(poses);
  if (!truth.ok()) return truth.status();
  readers::StartedReader files(*std::move(reader));
  auto scans = std::make_shared<std::vector<Scan>>();
  Drive drive;
  drive.sensor = files.sensor();
  drive.wrong_m = 1;  // References err themselves, by the motion within scans if nothing else.
  for (;;) {
    const auto recorded = files.Next();
    if (!recorded.ok()) return recorded.status();
    if (!recorded->has_value()) break;
    const int i = static_cast<int>(scans->size());
    auto scan = codec::DecodeScan((*recorded)->payload, i + 1, (*recorded)->end_stamp_ns);
    if (!scan.ok()) return scan.status();
    scans->push_back(*std::move(scan));
    drive.shots.push_back({i, (*recorded)->end_stamp_ns});
  }
  if (truth->size() < scans->size()) {
    return absl::InvalidArgumentError(absl::StrCat(poses, " has ", truth->size(), " poses for ",
                                                   scans->size(), " scans; one each is needed"));
  }
  drive.scan_of = [scans](int turn) { return (*scans)[turn]; };
  drive.truth_of = [truth = *std::move(truth)](int turn) { return truth[turn]; };
  return drive;
}

}  // namespace isthmus::bench
