#include "client/readers/messages/decode/place_message.h"

#include <absl/strings/str_cat.h>

#include <array>
#include <cmath>

#include "client/readers/messages/decode/message_fields.h"

namespace isthmus::readers {
namespace {

constexpr size_t kLeastTransformBytes = 8 + 4 + 4 + 7 * 8;  // Format: without names, of ROS 2.
constexpr double kLeastQuaternionNorm = 1e-6;               // Format: below, it is taken for zero.

double Sigma(double variance) {
  return std::isfinite(variance) && variance > 0 ? std::sqrt(variance) : 0;
}

}  // namespace

absl::StatusOr<std::optional<GnssFix>> DecodeNavSatFix(absl::string_view encoding,
                                                       absl::string_view bytes, int64_t log_ns) {
  absl::StatusOr<FieldReader> opened = OpenFields(encoding, bytes);
  if (!opened.ok()) return opened.status();
  FieldReader& reader = *opened;
  const MessageHeader header = ReadHeader(reader);
  const auto status = reader.Read<int8_t>();
  reader.Read<uint16_t>();  // The systems of satellites.
  GnssFix fix;
  fix.stamp_ns = header.stamp_ns == 0 ? log_ns : header.stamp_ns;
  fix.frame = header.frame;
  fix.latitude_deg = reader.Read<double>();
  fix.longitude_deg = reader.Read<double>();
  fix.altitude_m = reader.Read<double>();
  std::array<double, 9> covariance = {};  // East, north, up; m2.
  for (double& value : covariance) value = reader.Read<double>();
  const bool known = reader.Read<uint8_t>() != 0;
  if (!reader.ok()) return TooShort("NavSatFix");
  const bool valid = status >= 0 && std::abs(fix.latitude_deg) <= 90 &&
                     std::abs(fix.longitude_deg) <= 360 && std::isfinite(fix.altitude_m);
  if (!valid) return std::nullopt;
  if (known) {
    fix.sigma_east_m = Sigma(covariance[0]);
    fix.sigma_north_m = Sigma(covariance[4]);
    fix.sigma_up_m = Sigma(covariance[8]);
  }
  return fix;
}

absl::StatusOr<std::vector<StaticTransform>> DecodeTransforms(absl::string_view encoding,
                                                              absl::string_view bytes) {
  absl::StatusOr<FieldReader> opened = OpenFields(encoding, bytes);
  if (!opened.ok()) return opened.status();
  FieldReader& reader = *opened;
  std::vector<StaticTransform> transforms(reader.ReadCount(kLeastTransformBytes));
  for (StaticTransform& transform : transforms) {
    transform.parent = ReadHeader(reader).frame;
    transform.child = std::string(reader.ReadString());
    Eigen::Vector3d translation = Eigen::Vector3d::Zero();
    for (double& value : translation) value = reader.Read<double>();
    Eigen::Vector4d rotation = Eigen::Vector4d::Zero();  // x y z w, as Eigen's coefficients.
    for (double& value : rotation) value = reader.Read<double>();
    if (!reader.ok()) return TooShort("TFMessage");
    if (!translation.allFinite() || !rotation.allFinite() ||
        rotation.norm() < kLeastQuaternionNorm) {
      return absl::InvalidArgumentError(
          absl::StrCat("the transform from '", transform.child, "' to '", transform.parent,
                       "' has no rotation, or numbers that are not finite; correct its publisher"));
    }
    transform.T_parent_child = Pose(Eigen::Quaterniond(rotation), translation);
  }
  if (!reader.ok()) return TooShort("TFMessage");
  return transforms;
}

absl::StatusOr<std::string> DecodeString(absl::string_view encoding, absl::string_view bytes) {
  absl::StatusOr<FieldReader> reader = OpenFields(encoding, bytes);
  if (!reader.ok()) return reader.status();
  std::string text(reader->ReadString());
  if (!reader->ok()) return TooShort("String");
  return text;
}

}  // namespace isthmus::readers
