#include "core/formats/tum.h"

#include <absl/strings/ascii.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>
#include <absl/strings/str_split.h>
#include <absl/strings/strip.h>

#include <array>
#include <cmath>
#include <vector>

#include "core/formats/pose_limit.h"
#include "core/io/file_io.h"
#include "core/nanoseconds.h"

namespace isthmus::formats {
namespace {

// The year 2115: the nanoseconds between any two such stamps still are an int64.
constexpr double kMaxSeconds = 4.6e9;

absl::Status BadTumLine(size_t line, const std::string& why) {
  return absl::InvalidArgumentError(
      absl::StrCat("line ", line, ": ", why, "; expected: stamp tx ty tz qx qy qz qw"));
}

bool AllDigits(absl::string_view text) {
  for (char c : text) {
    if (!absl::ascii_isdigit(static_cast<unsigned char>(c))) return false;
  }
  return !text.empty();
}

// A double holds a stamp of today to 0.2 us only, so plain decimals are read as two whole numbers.
bool ParseStamp(absl::string_view text, int64_t* stamp_ns) {
  const size_t dot = text.find('.');
  const absl::string_view whole = text.substr(0, dot);
  std::string fraction(dot == absl::string_view::npos ? "0" : text.substr(dot + 1));
  int64_t seconds = 0, ns = 0;
  if (AllDigits(whole) && AllDigits(fraction) && absl::SimpleAtoi(whole, &seconds) &&
      static_cast<double>(seconds) < kMaxSeconds) {
    fraction.resize(9, '0');
    if (!absl::SimpleAtoi(fraction, &ns)) return false;
    *stamp_ns = seconds * kNsPerSecond + ns;
    return true;
  }
  double value = 0;  // Signs and exponents.
  if (!absl::SimpleAtod(text, &value) || !(std::abs(value) < kMaxSeconds)) return false;
  *stamp_ns = static_cast<int64_t>(std::llround(value * 1e9));
  return true;
}

absl::StatusOr<StampedPose> ParseLine(absl::string_view line, size_t number) {
  const std::vector<absl::string_view> words =
      absl::StrSplit(line, absl::ByAnyChar(" \t,"), absl::SkipEmpty());
  if (words.size() != 8) {
    return BadTumLine(number, absl::StrCat(words.size(), " values instead of 8"));
  }
  StampedPose stamped;
  if (!ParseStamp(words[0], &stamped.stamp_ns)) {
    return BadTumLine(number, absl::StrCat("'", words[0], "' is not a time in seconds"));
  }
  std::array<double, 7> v{};
  for (size_t i = 0; i < v.size(); ++i) {
    if (!absl::SimpleAtod(words[i + 1], &v[i]) || !(std::abs(v[i]) <= kMaxPoseM)) {
      return BadTumLine(number,
                        absl::StrCat("'", words[i + 1], "' is not a finite number up to 1e9"));
    }
  }
  const Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
  if (rotation.norm() < 1e-3) return BadTumLine(number, "the quaternion is zero");
  stamped.pose = Pose(rotation, Eigen::Vector3d(v[0], v[1], v[2]));
  return stamped;
}

}  // namespace

absl::StatusOr<Trajectory> ParseTum(const std::string& text) {
  Trajectory trajectory;
  size_t number = 0;
  const absl::string_view lines = absl::StripPrefix(text, "\xEF\xBB\xBF");  // Byte-order mark.
  for (absl::string_view line : absl::StrSplit(lines, '\n')) {
    ++number;
    line = absl::StripAsciiWhitespace(line);
    if (line.empty() || line.front() == '#') continue;
    absl::StatusOr<StampedPose> stamped = ParseLine(line, number);
    if (!stamped.ok()) return stamped.status();
    trajectory.push_back(*stamped);
  }
  return trajectory;
}

std::string FormatTum(const Trajectory& trajectory) {
  std::string text = "# stamp tx ty tz qx qy qz qw\n";
  for (const StampedPose& stamped : trajectory) {
    const Eigen::Vector3d& t = stamped.pose.translation();
    const Eigen::Quaterniond& q = stamped.pose.rotation();
    // The sign apart, because -0.5 s has a whole part of zero.
    const bool negative = stamped.stamp_ns < 0;
    const uint64_t ns = negative ? -static_cast<uint64_t>(stamped.stamp_ns)
                                 : static_cast<uint64_t>(stamped.stamp_ns);
    absl::StrAppendFormat(&text, "%s%u.%09u %.9g %.9g %.9g %.12g %.12g %.12g %.12g\n",
                          negative ? "-" : "", ns / kNsPerSecond, ns % kNsPerSecond, t.x(), t.y(),
                          t.z(), q.x(), q.y(), q.z(), q.w());
  }
  return text;
}

absl::StatusOr<Trajectory> ReadTum(const std::string& path) {
  absl::StatusOr<std::string> text = io::ReadFile(path);
  if (!text.ok()) return text.status();
  absl::StatusOr<Trajectory> trajectory = ParseTum(*text);
  if (trajectory.ok()) return trajectory;
  return absl::Status(trajectory.status().code(),
                      absl::StrCat(path, ": ", trajectory.status().message()));
}

absl::Status WriteTum(const std::string& path, const Trajectory& trajectory) {
  return io::WriteFile(path, FormatTum(trajectory));
}

}  // namespace isthmus::formats
