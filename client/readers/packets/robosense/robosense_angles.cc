#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/readers/packets/angle_file.h"
#include "client/readers/packets/robosense/robosense_bytes.h"
#include "client/readers/packets/robosense/robosense_packet.h"

namespace isthmus::readers::robosense {
namespace {

constexpr absl::string_view kDifopId("\xA5\xFF\x00\x5A\x11\x11\x55\x55", 8);  // Format
constexpr size_t kReturnsAt = 300;                                            // Format
constexpr size_t kAnglesAt = 468;       // Format: elevations, and behind them azimuths.
constexpr size_t kRs16AnglesAt = 1165;  // Format
constexpr uint8_t kUnknown = 0xFF;      // Format: in place of a sign.

// A sign and two bytes. Degrees.
double AngleAt(absl::string_view bytes, size_t at, double unit_deg) {
  const double size = BigAt16(bytes, at + 1) * unit_deg;
  return ByteAt(bytes, at) == 0 ? size : -size;
}

// Ten thousandths of a degree in three bytes; the lower half looks down.
std::optional<std::vector<double>> Rs16Elevations(absl::string_view difop) {
  std::vector<double> elevations(16);
  bool any = false;
  for (size_t i = 0; i < 16; ++i) {
    const size_t at = kRs16AnglesAt + 3 * i;
    const uint32_t value = uint32_t{ByteAt(difop, at)} << 16 | BigAt16(difop, at + 1);
    any = any || (value != 0 && value != 0xFFFFFF);
    elevations[i] = value * 1e-4 * (i < 8 ? -1 : 1);
  }
  return any ? std::optional(elevations) : std::nullopt;
}

bool ArePlausible(const std::vector<double>& elevations) {
  bool differ = false;
  for (const double elevation : elevations) {
    if (std::abs(elevation) > 90) return false;
    differ = differ || elevation != elevations[0];
  }
  return differ;
}

// The angles of the unit; empty where the sensor does not know them yet.
std::optional<Calibration> AnglesOf(absl::string_view difop, Model model) {
  constexpr char kSource[] = "the angles that the sensor sends (DIFOP)";
  const auto lasers = static_cast<size_t>(SpecOf(model).lasers);
  std::vector<double> elevations(lasers), azimuths(lasers);
  if (model == Model::kRs16) {
    const std::optional<std::vector<double>> told = Rs16Elevations(difop);
    if (!told || !ArePlausible(*told)) return std::nullopt;
    return MakeCalibration(kSource, 16, told->data(), nullptr);
  }
  const double unit_deg = model == Model::kRs32 ? 1e-3 : 1e-2;
  const size_t rows = lasers <= 32 ? 32 : 128;  // Rows with room in the packet.
  for (size_t i = 0; i < lasers; ++i) {
    if (ByteAt(difop, kAnglesAt + 3 * i) == kUnknown) return std::nullopt;
    elevations[i] = AngleAt(difop, kAnglesAt + 3 * i, unit_deg);
    azimuths[i] = AngleAt(difop, kAnglesAt + 3 * (rows + i), unit_deg);
  }
  if (!ArePlausible(elevations)) return std::nullopt;
  return MakeCalibration(kSource, SpecOf(model).lasers, elevations.data(), azimuths.data());
}

// Empty for models whose units differ.
std::optional<Calibration> NominalAngles(Model model) {
  if (model != Model::kRs16) return std::nullopt;
  std::vector<double> elevations(16);
  for (size_t i = 0; i < 16; ++i) {
    elevations[i] = i < 8 ? -15 + 2 * static_cast<double>(i) : 31 - 2 * static_cast<double>(i);
  }
  return MakeCalibration("the nominal angles of the RS-LiDAR-16", 16, elevations.data(), nullptr);
}

}  // namespace

bool IsDifop(absl::string_view bytes) {
  return bytes.size() == kPacketBytes && absl::StartsWith(bytes, kDifopId);
}

bool SendsBothReturns(absl::string_view difop, Model model) {
  const bool ruby = model == Model::kRuby80 || model == Model::kRuby128;
  return ByteAt(difop, kReturnsAt) == (ruby ? 3 : 0);
}

absl::StatusOr<Calibration> FindAngles(const std::string& csv, absl::string_view difop,
                                       Model model) {
  if (!csv.empty()) {
    absl::StatusOr<Calibration> given = ParseAngles(csv, SpecOf(model).lasers);
    if (!given.ok()) return absl::FailedPreconditionError(given.status().message());
    return given;
  }
  std::optional<Calibration> found;
  if (!difop.empty()) found = AnglesOf(difop, model);
  if (!found) found = NominalAngles(model);
  if (found) return *std::move(found);
  return absl::FailedPreconditionError(
      absl::StrCat("a ", SpecOf(model).name,
                   " needs the angles of its unit: capture its other port too (DIFOP, 7788), or "
                   "give the CSV of its angles (elevation, azimuth) as the calibration"));
}

}  // namespace isthmus::readers::robosense
