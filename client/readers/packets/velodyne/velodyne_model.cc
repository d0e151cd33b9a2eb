#include "client/readers/packets/velodyne/velodyne_model.h"

#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include "core/geometry/angles.h"

namespace isthmus::readers::velodyne {
namespace {

// VLP-16 User Manual, table 9-1: degrees and millimetres of each laser.
constexpr double kVlp16Elevations[] = {-15, 1, -13, 3,  -11, 5,  -9, 7,
                                       -7,  9, -5,  11, -3,  13, -1, 15};
constexpr double kVlp16Heights[] = {11.2, -0.7, 9.7, -2.2, 8.1, -3.7, 6.6, -5.1,
                                    5.1,  -6.6, 3.7, -8.1, 2.2, -9.7, 0.7, -11.2};
constexpr double kHiResElevations[] = {-10.00, 0.67, -8.67, 2.00, -7.33, 3.33, -6.00, 4.67,
                                       -4.67,  6.00, -3.33, 7.33, -2.00, 8.67, -0.67, 10.00};
constexpr double kHiResHeights[] = {7.4, -0.9, 6.5, -1.8, 5.5, -2.7, 4.6, -3.7,
                                    3.7, -4.6, 2.7, -5.5, 1.8, -6.5, 0.9, -7.4};

// VLP-32C User Manual, table 9-2: degrees of each laser; azimuth offsets are added to azimuths.
constexpr double kVlp32Elevations[] = {
    -25.0,  -1.0,   -1.667, -15.639, -11.31, 0.0,    -0.667, -8.843, -7.254, 0.333,  -0.333,
    -6.148, -5.333, 1.333,  0.667,   -4.0,   -4.667, 1.667,  1.0,    -3.667, -3.333, 3.333,
    2.333,  -2.667, -3.0,   7.0,     4.667,  -2.333, -2.0,   15.0,   10.333, -1.333};
constexpr double kVlp32Offsets[] = {
    1.4, -4.2, 1.4, -1.4, 1.4, -1.4, 4.2, -1.4, 1.4, -4.2, 1.4, -1.4, 4.2, -1.4, 4.2, -1.4,
    1.4, -4.2, 1.4, -4.2, 4.2, -1.4, 1.4, -1.4, 1.4, -1.4, 1.4, -4.2, 4.2, -1.4, 1.4, -1.4};

// HDL-32E User Manual, table of the firing order: two banks of 16, which take turns.
constexpr double kHdl32Elevations[] = {-30.67, -9.33, -29.33, -8.00, -28.00, -6.67, -26.67, -5.33,
                                       -25.33, -4.00, -24.00, -2.67, -22.67, -1.33, -21.33, 0.00,
                                       -20.00, 1.33,  -18.67, 2.67,  -17.33, 4.00,  -16.00, 5.33,
                                       -14.67, 6.67,  -13.33, 8.00,  -12.00, 9.33,  -10.67, 10.67};

Calibration FromTables(const char* manual, int lasers, const double* elevations_deg,
                       const double* offsets_deg, const double* heights_mm) {
  Calibration calibration;
  calibration.source = absl::StrCat("the tables of the ", manual, " User Manual");
  for (int i = 0; i < lasers; ++i) {
    Laser laser;
    laser.elevation = elevations_deg[i] * kRadPerDeg;
    if (offsets_deg != nullptr) laser.rotation = -offsets_deg[i] * kRadPerDeg;
    if (heights_mm != nullptr) laser.height = heights_mm[i] * 1e-3;
    calibration.lasers.push_back(laser);
  }
  return calibration;
}

// HDL-64E S3: both banks fire at once, four lasers one after the other, and the packet is stamped
// at its end. Microseconds before that of the last group of four, and from group to group.
struct Hdl64Timing {
  std::array<double, 4> group;
  double firing;
};
constexpr Hdl64Timing kHdl64Single = {{6.0, 4.74, 3.54, 2.34}, 48.0};
constexpr Hdl64Timing kHdl64Dual = {{7.2, 5.9, 4.7, 3.5}, 57.6};

double Hdl64Time(const Hdl64Timing& timing, int firings_behind, int laser) {
  const int groups_behind = (kLasersPerBlock - 1 - laser) / 4;
  return -(firings_behind * timing.firing + groups_behind * timing.group[0] +
           timing.group[laser % 4]);
}

}  // namespace

const char* SensorName(Model model) {
  switch (model) {
    case Model::kVlp16:
    case Model::kPuckHiRes:
      return "vlp16";
    case Model::kVlp32:
      return "vlp32";
    case Model::kHdl32:
      return "hdl32";
    case Model::kHdl64:
      break;
  }
  return "hdl64";
}

int Lasers(Model model) {
  if (model == Model::kVlp16 || model == Model::kPuckHiRes) return 16;
  return model == Model::kHdl64 ? 64 : 32;
}

absl::StatusOr<Model> ModelOfName(absl::string_view name) {
  std::string letters;
  for (const char c : absl::AsciiStrToLower(name)) {
    if (absl::ascii_isalnum(c)) letters += c;
  }
  if (absl::StartsWith(letters, "velodyne")) letters.erase(0, 8);
  if (letters.size() > 5) letters.resize(5);  // HDL-64E S3, VLP-32C
  for (const Model model : {Model::kVlp16, Model::kVlp32, Model::kHdl32, Model::kHdl64}) {
    if (letters == SensorName(model)) return model;
  }
  return absl::InvalidArgumentError(
      absl::StrCat("packets of a \"", name,
                   "\" cannot be read: those of Velodyne's vlp16, vlp32, "
                   "hdl32 and hdl64 can, and Ouster's with their metadata"));
}

std::optional<Model> ModelOf(const Packet& packet) {
  for (int block = 0; block < kBlocks; ++block) {
    if (packet.flag(block) == kLower) return Model::kHdl64;
  }
  switch (static_cast<Product>(packet.product())) {
    case Product::kHdl32:
      return Model::kHdl32;
    case Product::kVlp16:
      return Model::kVlp16;
    case Product::kPuckHiRes:
      return Model::kPuckHiRes;
    case Product::kVlp32:
      return Model::kVlp32;
    case Product::kVls128:
      break;
  }
  return std::nullopt;
}

std::optional<Calibration> ManualCalibration(Model model) {
  switch (model) {
    case Model::kVlp16:
      return FromTables("VLP-16", 16, kVlp16Elevations, nullptr, kVlp16Heights);
    case Model::kPuckHiRes:
      return FromTables("VLP-16 (Puck Hi-Res)", 16, kHiResElevations, nullptr, kHiResHeights);
    case Model::kVlp32: {
      Calibration calibration = FromTables("VLP-32C", 32, kVlp32Elevations, kVlp32Offsets, nullptr);
      calibration.range_unit_m = 0.004;
      return calibration;
    }
    case Model::kHdl32:
      return FromTables("HDL-32E", 32, kHdl32Elevations, nullptr, nullptr);
    case Model::kHdl64:
      break;
  }
  return std::nullopt;
}

int BlocksPerFiring(Model model, bool dual) {
  return (model == Model::kHdl64 ? 2 : 1) * (dual ? 2 : 1);
}

FiringTimes TimesOf(Model model, bool dual) {
  FiringTimes times;
  const int blocks = BlocksPerFiring(model, dual);
  for (int block = 0; block < kBlocks; ++block) {
    const int firing = block / blocks;
    for (int laser = 0; laser < kLasersPerBlock; ++laser) {
      double& time = times[block][laser];
      switch (model) {
        case Model::kVlp16:
        case Model::kPuckHiRes: {  // Each block has two firings of all 16.
          const int cycle = 2 * firing + laser / 16;
          time = cycle * 55.296 + (laser % 16) * 2.304;
          break;
        }
        case Model::kVlp32: {  // Two at once.
          const int pair = laser / 2;
          time = firing * 55.296 + pair * 2.304;
          break;
        }
        case Model::kHdl32:
          time = firing * 46.08 + laser * 1.152;
          break;
        case Model::kHdl64:
          time = Hdl64Time(dual ? kHdl64Dual : kHdl64Single, kBlocks / blocks - 1 - firing, laser);
          break;
      }
    }
  }
  return times;
}

}  // namespace isthmus::readers::velodyne
