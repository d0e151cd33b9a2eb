#include "client/readers/packets/ouster/ouster_metadata.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>

#include <cmath>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <utility>

#include "client/readers/packets/limits.h"

namespace isthmus::readers::ouster {
namespace {

using Json = nlohmann::json;

// Format: a turn by 180 degrees and 36.18 mm, of every sensor before metadata had it.
constexpr Transform kUsualLidarToSensor = {-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0.03618, 0, 0, 0, 1};

absl::Status BadMetadata(absl::string_view what) {
  return absl::InvalidArgumentError(
      absl::StrCat("the metadata cannot be used: ", what,
                   "; give the JSON that the sensor itself sends (firmware 2.0 or later)"));
}

// The value of that name, in the whole (flat) or in one of the parts (nested); null if not there.
const Json* FindValue(const Json& root, std::initializer_list<const char*> parts,
                      const char* name) {
  for (const char* part : parts) {
    const auto inner = root.find(part);
    if (inner == root.end() || !inner->is_object()) continue;
    if (const auto found = inner->find(name); found != inner->end()) return &*found;
  }
  const auto found = root.find(name);
  return found == root.end() ? nullptr : &*found;
}

const Json* FindFormat(const Json& root, const char* name) {
  return FindValue(root, {"lidar_data_format", "data_format"}, name);
}
const Json* FindBeam(const Json& root, const char* name) {
  return FindValue(root, {"beam_intrinsics"}, name);
}
const Json* FindInfo(const Json& root, const char* name) {
  return FindValue(root, {"sensor_info", "config_params", "lidar_intrinsics"}, name);
}

std::string TextOf(const Json* value) {
  return value != nullptr && value->is_string() ? value->get<std::string>() : std::string();
}

// Numbers within a million; empty otherwise.
std::vector<double> NumbersOf(const Json* value, size_t most) {
  std::vector<double> numbers;
  if (value == nullptr || !value->is_array() || value->size() > most) return numbers;
  for (const Json& number : *value) {
    if (!number.is_number()) return {};
    numbers.push_back(number.get<double>());
    if (!(std::abs(numbers.back()) < 1e6)) return {};
  }
  return numbers;
}

absl::StatusOr<int> CountOf(const Json* value, const char* name, int most) {
  if (value == nullptr || !value->is_number_integer()) {
    return BadMetadata(absl::StrCat("data_format has no ", name));
  }
  const double count = value->get<double>();
  if (count < 1 || count > most) {
    return BadMetadata(absl::StrCat(name, " is ", count, ", not from 1 to ", most));
  }
  return static_cast<int>(count);
}

absl::Status ReadProfile(const Json& root, Metadata& metadata) {
  std::string name = TextOf(FindFormat(root, "udp_profile_lidar"));
  if (name.empty()) name = TextOf(FindInfo(root, "udp_profile_lidar"));
  if (name.empty()) return absl::OkStatus();  // Before there were others.
  for (const Profile profile :
       {Profile::kLegacy, Profile::kSingle, Profile::kDual, Profile::kLowRate}) {
    metadata.profile = profile;
    if (name == NameOf(profile)) return absl::OkStatus();
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "the sensor sends in the UDP profile ", name,
      ", which is not read: set udp_profile_lidar to ", NameOf(Profile::kSingle), ", ",
      NameOf(Profile::kDual), ", ", NameOf(Profile::kLowRate), " or ", NameOf(Profile::kLegacy)));
}

absl::Status ReadFormat(const Json& root, Metadata& metadata) {
  const std::pair<const char*, std::pair<int*, int>> counts[] = {
      {"columns_per_frame", {&metadata.columns_per_frame, kMaxOusterColumns}},
      {"columns_per_packet", {&metadata.columns_per_packet, kMaxOusterColumns}},
      {"pixels_per_column", {&metadata.pixels_per_column, kMaxOusterRows}}};
  for (const auto& [name, count] : counts) {
    const absl::StatusOr<int> value = CountOf(FindFormat(root, name), name, count.second);
    if (!value.ok()) return value.status();
    *count.first = *value;
  }
  return ReadProfile(root, metadata);
}

absl::Status ReadBeams(const Json& root, Metadata& metadata) {
  const size_t rows = static_cast<size_t>(metadata.pixels_per_column);
  metadata.beam_altitudes = NumbersOf(FindBeam(root, "beam_altitude_angles"), rows);
  metadata.beam_azimuths = NumbersOf(FindBeam(root, "beam_azimuth_angles"), rows);
  if (metadata.beam_altitudes.size() != rows || metadata.beam_azimuths.size() != rows) {
    return BadMetadata(absl::StrCat("beam_altitude_angles and beam_azimuth_angles must be ", rows,
                                    " numbers each"));
  }
  const Json* transform = FindBeam(root, "beam_to_lidar_transform");
  const Json* length = FindBeam(root, "lidar_origin_to_beam_origin_mm");
  if (transform != nullptr) {
    const std::vector<double> numbers = NumbersOf(transform, 16);
    if (numbers.size() != 16) return BadMetadata("beam_to_lidar_transform must be 16 numbers");
    metadata.beam_forward_m = numbers[3] * 1e-3;
    metadata.beam_up_m = numbers[11] * 1e-3;
  } else if (length != nullptr && length->is_number() && std::abs(length->get<double>()) < 1e4) {
    metadata.beam_forward_m = length->get<double>() * 1e-3;
  } else {
    return BadMetadata("lidar_origin_to_beam_origin_mm is missing");
  }
  return absl::OkStatus();
}

absl::Status ReadTransform(const Json& root, Metadata& metadata) {
  metadata.lidar_to_sensor = kUsualLidarToSensor;
  const Json* given = FindInfo(root, "lidar_to_sensor_transform");
  if (given == nullptr) return absl::OkStatus();
  const std::vector<double> numbers = NumbersOf(given, 16);
  if (numbers.size() != 16) return BadMetadata("lidar_to_sensor_transform must be 16 numbers");
  for (size_t i = 0; i < 16; ++i) {
    const bool shift = i == 3 || i == 7 || i == 11;
    metadata.lidar_to_sensor[i] = numbers[i] * (shift ? 1e-3 : 1.0);
  }
  return absl::OkStatus();
}

}  // namespace

const char* NameOf(Profile profile) {
  switch (profile) {
    case Profile::kLegacy:
      return "LEGACY";
    case Profile::kSingle:
      return "RNG19_RFL8_SIG16_NIR16";
    case Profile::kDual:
      return "RNG19_RFL8_SIG16_NIR16_DUAL";
    case Profile::kLowRate:
      break;
  }
  return "RNG15_RFL8_NIR8";
}

absl::StatusOr<Metadata> ParseMetadata(const std::string& json) {
  if (json.size() > kMaxDescriptionBytes) return BadMetadata("it is too large");
  const Json root = Json::parse(json, nullptr, /*allow_exceptions=*/false);
  if (!root.is_object()) return BadMetadata("it is no JSON object");
  Metadata metadata;
  for (const auto read : {ReadFormat, ReadBeams, ReadTransform}) {
    if (const absl::Status status = read(root, metadata); !status.ok()) return status;
  }
  metadata.product = TextOf(FindInfo(root, "prod_line"));
  (void)absl::SimpleAtoi(TextOf(FindInfo(root, "prod_sn")), &metadata.serial);
  for (const char* name : {"initialization_id", "init_id"}) {
    const Json* start = FindInfo(root, name);
    if (start != nullptr && start->is_number_unsigned()) metadata.start = start->get<uint32_t>();
  }
  return metadata;
}

}  // namespace isthmus::readers::ouster
