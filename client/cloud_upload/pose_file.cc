#include "client/cloud_upload/pose_file.h"

#include <absl/strings/ascii.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_split.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "client/cloud_upload/limits.h"
#include "client/readers/folder/times_file.h"
#include "core/formats/tum.h"
#include "core/geometry/near_origin.h"
#include "core/io/file_io.h"
#include "server/pose_graph/g2o.h"

namespace isthmus::cloud_upload {
namespace {

constexpr size_t kMatrixNumbers = 12;  // Format.

std::vector<absl::string_view> Words(absl::string_view line) {
  return absl::StrSplit(line, absl::ByAnyChar(" \t,\r"), absl::SkipEmpty());
}

bool IsPassedOver(absl::string_view line) {
  line = absl::StripAsciiWhitespace(line);
  return line.empty() || line.front() == '#';
}

PoseFormat FormatOf(const std::string& text) {
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    if (IsPassedOver(line)) continue;
    const std::vector<absl::string_view> words = Words(line);
    if (!words.empty() && absl::ascii_isupper(static_cast<unsigned char>(words[0][0]))) {
      return PoseFormat::kG2o;
    }
    return words.size() == kMatrixNumbers ? PoseFormat::kKitti : PoseFormat::kTum;
  }
  return PoseFormat::kTum;
}

absl::StatusOr<Pose> ParseMatrix(absl::string_view line, size_t number) {
  const std::vector<absl::string_view> words = Words(line);
  if (words.size() != kMatrixNumbers) {
    return absl::InvalidArgumentError(absl::StrCat("line ", number, ": ", words.size(),
                                                   " values instead of 12, the upper three rows of "
                                                   "a 4x4 matrix"));
  }
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (size_t i = 0; i < words.size(); ++i) {
    double& value = matrix(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4));
    if (!absl::SimpleAtod(words[i], &value) || !std::isfinite(value)) {
      return absl::InvalidArgumentError(
          absl::StrCat("line ", number, ": '", words[i], "' is not a finite number"));
    }
  }
  const Eigen::Matrix3d R = matrix.topLeftCorner<3, 3>();
  if (!(R.transpose() * R).isIdentity(kNoRotation) || R.determinant() < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("line ", number, ": the numbers 1-3, 5-7 and 9-11 are no rotation"));
  }
  return Pose::FromMatrix(matrix);
}

absl::StatusOr<Trajectory> ParseKitti(const std::string& text) {
  Trajectory poses;
  size_t number = 0;
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    ++number;
    if (IsPassedOver(line)) continue;
    const absl::StatusOr<Pose> pose = ParseMatrix(line, number);
    if (!pose.ok()) return pose.status();
    poses.push_back({0, *pose});
  }
  return poses;
}

absl::StatusOr<Trajectory> ParseVertices(const std::string& text) {
  std::istringstream input(text);
  const auto vertices = pose_graph::ReadG2oVertices(input);
  if (!vertices.ok()) return vertices.status();
  Trajectory poses;
  for (const Pose& pose : *vertices) poses.push_back({0, pose});
  return poses;
}

// Gives poses the times beside them, where there are as many.
absl::Status AddTimes(const std::filesystem::path& times, PoseFile& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(times, error)) return absl::OkStatus();
  const absl::StatusOr<std::string> text = io::ReadFile(times);
  if (!text.ok()) return text.status();
  const absl::StatusOr<std::vector<int64_t>> stamps = readers::ParseTimes(*text);
  if (!stamps.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat(times.string(), ": ", stamps.status().message()));
  }
  file.has_stamps = stamps->size() == file.poses.size();
  for (size_t i = 0; file.has_stamps && i < file.poses.size(); ++i) {
    file.poses[i].stamp_ns = (*stamps)[i];
  }
  return absl::OkStatus();
}

// Two poses of one instant that are not the same cannot both be right.
absl::Status CheckInstants(Trajectory poses) {
  std::stable_sort(poses.begin(), poses.end(), [](const StampedPose& a, const StampedPose& b) {
    return a.stamp_ns < b.stamp_ns;
  });
  for (size_t i = 1; i < poses.size(); ++i) {
    if (poses[i].stamp_ns != poses[i - 1].stamp_ns) continue;
    const Pose apart = poses[i - 1].pose.Inverse() * poses[i].pose;
    if (apart.translation().norm() <= kSamePoseM && RotationAngle(apart) <= kSamePoseRad) continue;
    return absl::InvalidArgumentError(
        absl::StrFormat("two poses of %.6f s are %.3f m apart: keep one of them",
                        1e-9 * static_cast<double>(poses[i].stamp_ns), apart.translation().norm()));
  }
  return absl::OkStatus();
}

// Map frames have coordinates of 32 bits, so a frame far from its origin would lose digits.
void MoveNear(PoseFile& file) {
  file.moved_by = ShiftToOrigin(file.poses.front().pose.translation());
  for (StampedPose& pose : file.poses) {
    pose.pose = Pose(Eigen::Quaterniond::Identity(), file.moved_by) * pose.pose;
  }
}

}  // namespace

absl::StatusOr<PoseFile> ParsePoses(const std::string& text) {
  PoseFile file;
  file.format = FormatOf(text);
  file.has_stamps = file.format == PoseFormat::kTum;
  absl::StatusOr<Trajectory> poses = file.format == PoseFormat::kTum     ? formats::ParseTum(text)
                                     : file.format == PoseFormat::kKitti ? ParseKitti(text)
                                                                         : ParseVertices(text);
  if (!poses.ok()) return poses.status();
  if (poses->empty()) {
    return absl::InvalidArgumentError(
        "holds no poses: give lines of TUM (stamp tx ty tz qx qy qz qw), of KITTI (12 numbers) or "
        "of g2o (VERTEX_SE3:QUAT); a graph of edges only gets some by `isthmus optimize`");
  }
  file.poses = *std::move(poses);
  if (file.has_stamps) {
    if (absl::Status status = CheckInstants(file.poses); !status.ok()) return status;
  }
  MoveNear(file);
  return file;
}

absl::StatusOr<PoseFile> ReadPoses(const std::string& path) {
  const absl::StatusOr<std::string> text = io::ReadFile(path);
  if (!text.ok()) return text.status();
  absl::StatusOr<PoseFile> file = ParsePoses(*text);
  if (!file.ok()) {
    return absl::Status(file.status().code(), absl::StrCat(path, ": ", file.status().message()));
  }
  if (file->format == PoseFormat::kKitti) {
    const auto times = std::filesystem::path(path).parent_path() / "times.txt";
    if (absl::Status status = AddTimes(times, *file); !status.ok()) return status;
  }
  return file;
}

const char* ToString(PoseFormat format) {
  switch (format) {
    case PoseFormat::kTum:
      return "TUM";
    case PoseFormat::kKitti:
      return "KITTI";
    case PoseFormat::kG2o:
      break;
  }
  return "g2o";
}

}  // namespace isthmus::cloud_upload
