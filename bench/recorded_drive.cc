#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <memory>
#include <utility>

#include "bench/scenarios.h"
#include "client/readers/folder/scan_folder.h"
#include "core/codec/scan_decoder.h"
#include "core/io/file_io.h"

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

absl::StatusOr<Drive> RecordedDrive(const std::string& folder, const std::string& poses) {
  const auto files = readers::ScanFolder::Open(folder);
  if (!files.ok()) return files.status();
  auto truth = ReadPoses(poses);
  if (!truth.ok()) return truth.status();
  if (truth->size() < files->size()) {
    return absl::InvalidArgumentError(absl::StrCat(poses, " has ", truth->size(), " poses for ",
                                                   files->size(), " scans; one each is needed"));
  }
  const auto sensor = files->GuessSensor();
  if (!sensor.ok()) return sensor.status();
  auto scans = std::make_shared<std::vector<Scan>>();
  Drive drive;
  drive.sensor = *sensor;
  drive.wrong_m = 1;  // References err themselves, by the motion within scans if nothing else.
  for (size_t i = 0; i < files->size(); ++i) {
    const auto payload = files->Read(i);
    if (!payload.ok()) return payload.status();
    auto scan = codec::DecodeScan(*payload, i + 1, files->stamp_ns(i));
    if (!scan.ok()) return scan.status();
    scans->push_back(*std::move(scan));
    drive.shots.push_back({static_cast<int>(i), files->stamp_ns(i)});
  }
  drive.scan_of = [scans](int turn) { return (*scans)[turn]; };
  drive.truth_of = [truth = *std::move(truth)](int turn) { return truth[turn]; };
  return drive;
}

}  // namespace isthmus::bench
