#include "client/readers/packets/velodyne/velodyne_model.h"

#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <vector>

#include "core/vlp32_angles.h"

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

// VLP-32C User Manual, table 9-2: degrees that are added to azimuths.
constexpr double kVlp32Offsets[] = {
    1.4, -4.2, 1.4, -1.4, 1.4, -1.4, 4.2, -1.4, 1.4, -4.2, 1.4, -1.4, 4.2, -1.4, 4.2, -1.4,
    1.4, -4.2, 1.4, -4.2, 4.2, -1.4, 1.4, -1.4, 1.4, -1.4, 1.4, -4.2, 4.2, -1.4, 1.4, -1.4};

// HDL-32E User Manual, table of the firing order: two banks of 16, which take turns.
constexpr double kHdl32Elevations[] = {-30.67, -9.33, -29.33, -8.00, -28.00, -6.67, -26.67, -5.33,
                                       -25.33, -4.00, -24.00, -2.67, -22.67, -1.33, -21.33, 0.00,
                                       -20.00, 1.33,  -18.67, 2.67,  -17.33, 4.00,  -16.00, 5.33,
                                       -14.67, 6.67,  -13.33, 8.00,  -12.00, 9.33,  -10.67, 10.67};

// VLS-128 User Manual, table of laser angles: elevations, and azimuth offsets that repeat each 8.
constexpr double kVls128Elevations[] = {
    -11.742, -1.99,   3.4,   -5.29,   -0.78, 4.61,  -4.08,   1.31,   -6.5,  -1.11,   4.28,  -4.41,
    0.1,     6.48,    -3.2,  2.19,    -3.86, 1.53,  -9.244,  -1.77,  2.74,  -5.95,   -0.56, 4.83,
    -2.98,   2.41,    -6.28, -0.89,   3.62,  -5.07, 0.32,    7.58,   -0.34, 5.18,    -3.64, 1.75,
    -25,     -2.43,   2.96,  -5.73,   0.54,  9.7,   -2.76,   2.63,   -7.65, -1.55,   3.84,  -4.85,
    3.18,    -5.51,   -0.12, 5.73,    -4.3,  1.09,  -16.042, -2.21,  4.06,  -4.63,   0.76,  15,
    -3.42,   1.97,    -6.85, -1.33,   -5.62, -0.23, 5.43,    -3.53,  0.98,  -19.582, -2.32, 3.07,
    -4.74,   0.65,    11.75, -2.65,   1.86,  -7.15, -1.44,   3.95,   -2.1,  3.29,    -5.4,  -0.01,
    4.5,     -4.19,   1.2,   -13.565, -1.22, 4.17,  -4.52,   0.87,   6.08,  -3.31,   2.08,  -6.65,
    1.42,    -10.346, -1.88, 3.51,    -6.06, -0.67, 4.72,    -3.97,  2.3,   -6.39,   -1,    4.39,
    -5.18,   0.21,    6.98,  -3.09,   4.98,  -3.75, 1.64,    -8.352, -2.54, 2.85,    -5.84, -0.45,
    8.43,    -2.87,   2.52,  -6.17,   -1.66, 3.73,  -4.96,   0.43};
constexpr double kVls128Offsets[] = {6.354, 4.548, 2.732, 0.911, -0.911, -2.732, -4.548, -6.354};

Calibration FromTables(const char* manual, int lasers, const double* elevations_deg,
                       const double* offsets_deg, const double* heights_mm) {
  Calibration calibration =
      MakeCalibration(absl::StrCat("the tables of the ", manual, " User Manual"), lasers,
                      elevations_deg, offsets_deg);
  if (heights_mm == nullptr) return calibration;
  for (Laser& laser : calibration.lasers) laser.height = *heights_mm++ * 1e-3;
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

// VLS-128: eight lasers at once, a pause in the middle and one at the end of a firing, and the
// packet is stamped behind its first lasers. Microseconds.
constexpr double kVls128Group = 2.665;  // Format
constexpr double kVls128Firing = 53.3;  // Format
constexpr double kVls128Stamp = 8.7;    // Format

double Vls128Time(int firing, int laser) {
  const int groups = laser / 8 + (laser >= 64 ? 1 : 0);
  return firing * kVls128Firing + groups * kVls128Group - kVls128Stamp;
}

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
    case Model::kVls128:
      return "vls128";
    case Model::kHdl64:
      break;
  }
  return "hdl64";
}

int Lasers(Model model) {
  if (model == Model::kVls128) return 128;
  if (model == Model::kVlp16 || model == Model::kPuckHiRes) return 16;
  return model == Model::kHdl64 ? 64 : 32;
}

absl::StatusOr<Model> ModelOfName(absl::string_view name) {
  std::string letters;
  for (const char c : absl::AsciiStrToLower(name)) {
    if (absl::ascii_isalnum(c)) letters += c;
  }
  if (absl::StartsWith(letters, "velodyne")) letters.erase(0, 8);
  for (const Model model :
       {Model::kVlp16, Model::kVlp32, Model::kHdl32, Model::kHdl64, Model::kVls128}) {
    if (absl::StartsWith(letters, SensorName(model))) return model;  // HDL-64E S3, VLP-32C
  }
  return absl::InvalidArgumentError(
      absl::StrCat("packets of a \"", name,
                   "\" cannot be read: Velodyne's vlp16, vlp32, hdl32, hdl64 and vls128 can, and "
                   "Ouster's sensors with their metadata"));
}

std::optional<Model> ModelOf(const Packet& packet) {
  int highest = 0;
  for (int block = 0; block < packet.blocks(); ++block) {
    highest = std::max(highest, packet.bank(block).value_or(0));
  }
  if (highest > 1) return Model::kVls128;
  if (highest == 1) return Model::kHdl64;
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
      return Model::kVls128;
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
      Calibration calibration =
          FromTables("VLP-32C", 32, kVlp32Elevations.data(), kVlp32Offsets, nullptr);
      calibration.range_unit_m = 0.004;
      return calibration;
    }
    case Model::kVls128: {
      std::vector<double> offsets;
      offsets.reserve(128);
      for (int i = 0; i < 128; ++i) offsets.push_back(kVls128Offsets[i % 8]);
      Calibration calibration =
          FromTables("VLS-128", 128, kVls128Elevations, offsets.data(), nullptr);
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
  const int banks = model == Model::kVls128 ? 4 : model == Model::kHdl64 ? 2 : 1;
  return banks * (dual ? 2 : 1);
}

int BlocksToOtherReturn(Model model) { return model == Model::kHdl64 ? 2 : 1; }

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
        case Model::kVls128: {
          const int bank = block % blocks / (dual ? 2 : 1);
          time = Vls128Time(firing, bank * kLasersPerBlock + laser);
          break;
        }
        case Model::kHdl64:
          time = Hdl64Time(dual ? kHdl64Dual : kHdl64Single, kBlocks / blocks - 1 - firing, laser);
          break;
      }
    }
  }
  return times;
}

}  // namespace isthmus::readers::velodyne
