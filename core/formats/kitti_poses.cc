#include "core/formats/kitti_poses.h"

#include <absl/strings/ascii.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_split.h>

#include <cmath>

#include "core/formats/pose_limit.h"

namespace isthmus::formats {
namespace {

constexpr size_t kMatrixValues = 12;
// Most that R^T R may be off the identity, each element: six digits are good to 1e-6, and some
// truths were written with four.
constexpr double kOrthonormal = 1e-2;

using MatrixWords = std::vector<absl::string_view>;

MatrixWords WordsOf(absl::string_view line) {
  line = absl::StripAsciiWhitespace(line);
  if (line.empty() || line.front() == '#') return {};
  return absl::StrSplit(line, absl::ByAnyChar(" \t,"), absl::SkipEmpty());
}

absl::Status BadKittiLine(size_t line, const std::string& why) {
  return absl::InvalidArgumentError(absl::StrCat(
      "line ", line, ": ", why, "; expected: the 12 numbers of [R t], row by row, as KITTI has"));
}

absl::StatusOr<Pose> ParseMatrix(const MatrixWords& words, size_t number) {
  if (words.size() != kMatrixValues) {
    return BadKittiLine(number, absl::StrCat(words.size(), " values instead of 12"));
  }
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  for (size_t i = 0; i < words.size(); ++i) {
    double& value = matrix(static_cast<Eigen::Index>(i / 4), static_cast<Eigen::Index>(i % 4));
    if (!absl::SimpleAtod(words[i], &value) || !(std::abs(value) <= kMaxPoseM)) {
      return BadKittiLine(number,
                          absl::StrCat("'", words[i], "' is not a finite number up to 1e9"));
    }
  }
  const Eigen::Matrix3d R = matrix.topLeftCorner<3, 3>();
  const Eigen::Matrix3d rest = R.transpose() * R - Eigen::Matrix3d::Identity();
  if (rest.cwiseAbs().maxCoeff() > kOrthonormal || R.determinant() < 0) {
    return BadKittiLine(number, "its left three columns are no rotation");
  }
  return Pose::FromMatrix(matrix);
}

}  // namespace

absl::StatusOr<std::vector<Pose>> ParseKittiPoses(const std::string& text) {
  std::vector<Pose> poses;
  size_t number = 0;
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    ++number;
    const MatrixWords words = WordsOf(line);
    if (words.empty()) continue;
    const absl::StatusOr<Pose> pose = ParseMatrix(words, number);
    if (!pose.ok()) return pose.status();
    poses.push_back(*pose);
  }
  return poses;
}

bool LooksLikeKittiPoses(const std::string& text) {
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    const MatrixWords words = WordsOf(line);
    if (!words.empty()) return words.size() == kMatrixValues;
  }
  return false;
}

std::string FormatKittiPoses(const Trajectory& trajectory) {
  std::string text;
  for (const StampedPose& stamped : trajectory) {
    const Eigen::Matrix3d R = stamped.pose.RotationMatrix();
    const Eigen::Vector3d& t = stamped.pose.translation();
    for (int row = 0; row < 3; ++row) {
      absl::StrAppendFormat(&text, "%.12g %.12g %.12g %.9g%s", R(row, 0), R(row, 1), R(row, 2),
                            t[row], row < 2 ? " " : "\n");
    }
  }
  return text;
}

}  // namespace isthmus::formats
