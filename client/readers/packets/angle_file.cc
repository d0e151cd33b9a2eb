#include "client/readers/packets/angle_file.h"

#include <absl/status/status.h>
#include <absl/strings/ascii.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>

#include <cmath>
#include <optional>
#include <vector>

#include "client/readers/packets/limits.h"

namespace isthmus::readers {
namespace {

absl::Status BadAngles(absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat("the calibration cannot be used: ", what,
                   "; it must be the CSV of the unit: laser, elevation and azimuth in degrees"));
}

// The numbers of a line; empty for a line of something else.
std::vector<double> NumbersOf(absl::string_view line) {
  std::vector<double> numbers;
  for (const absl::string_view cell : absl::StrSplit(line, ',')) {
    double number = 0;
    if (!absl::SimpleAtod(absl::StripAsciiWhitespace(cell), &number)) break;
    numbers.push_back(number);
  }
  return numbers;
}

}  // namespace

absl::StatusOr<Calibration> ParseAngles(const std::string& csv, int lasers) {
  if (csv.size() > kMaxDescriptionBytes) return BadAngles("it is too large");
  const size_t count = static_cast<size_t>(lasers);
  std::vector<double> elevations(count), azimuths(count);
  std::vector<bool> given(count);
  size_t lines = 0;
  for (const absl::string_view line : absl::StrSplit(csv, '\n')) {
    const std::vector<double> numbers = NumbersOf(line);
    if (numbers.size() < 2) continue;
    const double number = numbers.size() > 2 ? numbers[0] - 1 : static_cast<double>(lines);
    const double elevation = numbers[numbers.size() > 2 ? 1 : 0];
    const double azimuth = numbers[numbers.size() > 2 ? 2 : 1];
    if (!(number >= 0 && number < lasers) || number != std::floor(number)) {
      return BadAngles(
          absl::StrCat("it has a laser ", number + 1, ", and the sensor has ", lasers));
    }
    const auto laser = static_cast<size_t>(number);
    if (given[laser]) return BadAngles(absl::StrCat("laser ", number + 1, " is given twice"));
    if (!(std::abs(elevation) <= 90 && std::abs(azimuth) <= 360)) {
      return BadAngles(absl::StrCat("laser ", number + 1, " is no direction"));
    }
    given[laser] = true;
    elevations[laser] = elevation;
    azimuths[laser] = azimuth;
    ++lines;
  }
  if (lines != count) {
    return BadAngles(absl::StrCat("it has ", lines, " lasers, and the sensor has ", lasers));
  }
  return MakeCalibration("the calibration that was given", lasers, elevations.data(),
                         azimuths.data());
}

}  // namespace isthmus::readers
