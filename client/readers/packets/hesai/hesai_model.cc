#include "client/readers/packets/hesai/hesai_model.h"

#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <vector>

namespace isthmus::readers::hesai {
namespace {

constexpr Model kModels[] = {Model::kPandar40P,   Model::kPandar64,   Model::kPandarQt64,
                             Model::kPandarXt16,  Model::kPandarXt32, Model::kPandarXt32M,
                             Model::kPandarQt128, Model::kOt128};

// Pandar40P, Pandar64 and PandarQT User Manuals, tables of the channels: degrees.
constexpr double kP40Elevations[] = {
    15,    11,    8,     5,  3,     2,     1.67, 1.33,  1,     0.67, 0.33,  0,     -0.33, -0.67,
    -1,    -1.33, -1.66, -2, -2.33, -2.67, -3,   -3.33, -3.67, -4,   -4.33, -4.67, -5,    -5.33,
    -5.67, -6,    -7,    -8, -9,    -10,   -11,  -12,   -13,   -14,  -19,   -25};
constexpr double kP40Azimuths[] = {-1.042, -1.042, -1.042, -1.042, -1.042, -1.042, 3.125,  -5.208,
                                   -1.042, 3.125,  -5.208, -1.042, 3.125,  -5.208, -1.042, 3.125,
                                   -5.208, -1.042, 3.125,  -5.208, -1.042, 3.125,  -5.208, -1.042,
                                   3.125,  -5.208, -1.042, 3.125,  -5.208, -1.042, -1.042, -1.042,
                                   -1.042, -1.042, -1.042, -1.042, -1.042, -1.042, -1.042, -1.042};
constexpr double kP64Elevations[] = {
    14.882, 11.032, 8.059,  5.057,   3.04,    2.028,   1.86,   1.688,   1.522,  1.351,  1.184,
    1.013,  0.846,  0.675,  0.508,   0.337,   0.169,   0,      -0.169,  -0.337, -0.508, -0.675,
    -0.845, -1.013, -1.184, -1.351,  -1.522,  -1.688,  -1.86,  -2.028,  -2.198, -2.365, -2.536,
    -2.7,   -2.873, -3.04,  -3.21,   -3.375,  -3.548,  -3.712, -3.884,  -4.05,  -4.221, -4.385,
    -4.558, -4.72,  -4.892, -5.057,  -5.229,  -5.391,  -5.565, -5.726,  -5.898, -6.061, -7.063,
    -8.059, -9.06,  -9.885, -11.032, -12.006, -12.974, -13.93, -18.889, -24.897};
constexpr double kP64Pattern[] = {1.042, 3.125, 5.208, -5.208, -3.125, -1.042};

// Lasers 7 to 54 repeat, the others are at the first one's azimuth.
Calibration Pandar64Angles(const std::string& source) {
  std::vector<double> azimuths(64, -1.042);
  for (size_t i = 6; i < 54; ++i) azimuths[i] = kP64Pattern[i % 6];
  return MakeCalibration(source, 64, kP64Elevations, azimuths.data());
}

// From the uppermost down.
Calibration UniformAngles(const std::string& source, int lasers, double top_deg, double step_deg) {
  std::vector<double> elevations;
  for (int i = 0; i < lasers; ++i) elevations.push_back(top_deg - i * step_deg);
  return MakeCalibration(source, lasers, elevations.data(), nullptr);
}

}  // namespace

const char* NameOf(Model model) {
  switch (model) {
    case Model::kPandar40P:
      return "Pandar40P";
    case Model::kPandar64:
      return "Pandar64";
    case Model::kPandarQt64:
      return "PandarQT64";
    case Model::kPandarXt16:
      return "PandarXT16";
    case Model::kPandarXt32:
      return "PandarXT32";
    case Model::kPandarXt32M:
      return "PandarXT32M";
    case Model::kPandarQt128:
      return "PandarQT128";
    case Model::kOt128:
      break;
  }
  return "OT128";
}

int Lasers(Model model) {
  switch (model) {
    case Model::kPandarXt16:
      return 16;
    case Model::kPandarXt32:
    case Model::kPandarXt32M:
      return 32;
    case Model::kPandar40P:
      return 40;
    case Model::kPandar64:
    case Model::kPandarQt64:
      return 64;
    case Model::kPandarQt128:
    case Model::kOt128:
      break;
  }
  return 128;
}

absl::StatusOr<Model> ModelOfName(absl::string_view name) {
  std::string letters;
  for (const char c : absl::AsciiStrToLower(name)) {
    if (absl::ascii_isalnum(c)) letters += c;
  }
  for (const char* word : {"hesai", "pandar"}) {
    if (absl::StartsWith(letters, word)) letters.erase(0, absl::string_view(word).size());
  }
  for (const Model model : kModels) {
    std::string known = absl::AsciiStrToLower(NameOf(model));
    if (absl::StartsWith(known, "pandar")) known.erase(0, 6);
    if (letters == known) return model;
  }
  if (letters == "40") return Model::kPandar40P;
  if (letters == "qt") return Model::kPandarQt64;
  if (letters == "xt") return Model::kPandarXt32;
  if (letters == "xt32m2x") return Model::kPandarXt32M;
  if (absl::StartsWith(letters, "128")) return Model::kOt128;
  return absl::InvalidArgumentError(
      absl::StrCat("packets of a \"", name,
                   "\" cannot be read: Hesai's Pandar40P, Pandar64, QT64, QT128, XT16, XT32, "
                   "XT32M, OT128 and Pandar128 can"));
}

std::optional<Calibration> NominalCalibration(Model model) {
  const std::string source = absl::StrCat("the nominal angles of the ", NameOf(model),
                                          " (--calibration FILE.csv gives "
                                          "those of the unit)");
  switch (model) {
    case Model::kPandar40P:
      return MakeCalibration(source, 40, kP40Elevations, kP40Azimuths);
    case Model::kPandar64:
      return Pandar64Angles(source);
    case Model::kPandarXt16:
      return UniformAngles(source, 16, 15, 2);
    case Model::kPandarXt32:
      return UniformAngles(source, 32, 15, 1);
    case Model::kPandarXt32M:
      return UniformAngles(source, 32, 19.5, 1.3);
    case Model::kPandarQt64:
    case Model::kPandarQt128:
    case Model::kOt128:
      break;
  }
  return std::nullopt;
}

}  // namespace isthmus::readers::hesai
