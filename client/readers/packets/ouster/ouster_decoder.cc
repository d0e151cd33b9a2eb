#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <utility>

#include "client/readers/packets/limits.h"
#include "client/readers/packets/ouster/ouster_metadata.h"
#include "client/readers/packets/ouster/ouster_packet.h"
#include "client/readers/packets/packet_decoder.h"
#include "client/readers/packets/scan_builder.h"
#include "client/readers/packets/sensor_clock.h"
#include "core/codec/column.h"
#include "core/geometry/angles.h"

namespace isthmus::readers {
namespace {

using ouster::Metadata;
using ouster::PacketLayout;
using ouster::Pixel;

// Ouster Firmware User Manual, "Lidar Range to XYZ". With n the distance of the beam's origin from
// the axis and r the range, a point is (r - n) along the beam from there.
class BeamGeometry {
 public:
  explicit BeamGeometry(const Metadata& metadata)
      : to_sensor_(metadata.lidar_to_sensor),
        forward_(metadata.beam_forward_m),
        up_(metadata.beam_up_m),
        origin_(std::hypot(metadata.beam_forward_m, metadata.beam_up_m)) {
    for (int column = 0; column < metadata.columns_per_frame; ++column) {
      const double encoder =
          2 * std::numbers::pi * (1.0 - static_cast<double>(column) / metadata.columns_per_frame);
      columns_.push_back({std::cos(encoder), std::sin(encoder)});
    }
    for (size_t row = 0; row < metadata.beam_altitudes.size(); ++row) {
      const double altitude = metadata.beam_altitudes[row] * kRadPerDeg;
      const double azimuth = -metadata.beam_azimuths[row] * kRadPerDeg;
      rows_.push_back({std::cos(altitude) * std::cos(azimuth),
                       std::cos(altitude) * std::sin(azimuth), std::sin(altitude)});
    }
  }

  // In the sensor's frame, metres.
  std::array<float, 3> Locate(size_t column, size_t row, uint32_t range_mm) const {
    const auto [cos, sin] = columns_[column];
    const auto [forward, left, up] = rows_[row];
    const double length = range_mm * 1e-3 - origin_;
    const double x = length * (forward * cos - left * sin) + forward_ * cos;
    const double y = length * (forward * sin + left * cos) + forward_ * sin;
    const double z = length * up + up_;
    std::array<float, 3> point;
    for (size_t i = 0; i < 3; ++i) {
      point[i] = static_cast<float>(to_sensor_[4 * i] * x + to_sensor_[4 * i + 1] * y +
                                    to_sensor_[4 * i + 2] * z + to_sensor_[4 * i + 3]);
    }
    return point;
  }

 private:
  ouster::Transform to_sensor_;
  double forward_, up_, origin_;
  std::vector<std::array<double, 2>> columns_;  // Cosine and sine of the encoder's angle.
  std::vector<std::array<double, 3>> rows_;     // The beam's direction at encoder 0.
};

// "OS-1-32-G" is os1-32 (sensor_model.h).
std::string OusterSensorName(const Metadata& metadata) {
  const std::string product = absl::AsciiStrToLower(metadata.product);
  if (product.size() < 4 || product.substr(0, 3) != "os-" || !absl::ascii_isdigit(product[3])) {
    return {};
  }
  return absl::StrCat("os", product.substr(3, 1), "-", metadata.pixels_per_column);
}

class OusterDecoder : public PacketDecoder {
 public:
  explicit OusterDecoder(const Metadata& metadata)
      : layout_(metadata),
        geometry_(metadata),
        sensor_(OusterSensorName(metadata)),
        told_{metadata.serial, metadata.start},
        clock_(0),
        builder_({{"reflectivity", 0, ScalarType::kUint16}, {"range", 0, ScalarType::kUint32}}),
        seen_(static_cast<size_t>(metadata.columns_per_frame)) {}

  absl::Status Add(absl::string_view packet, int64_t arrival_ns,
                   std::vector<RecordedScan>* scans) override;
  void Flush(std::vector<RecordedScan>* scans) override {
    if (!builder_.empty()) scans->push_back(builder_.Finish(clock_.offset_ns()));
    seen_.assign(seen_.size(), false);
  }
  std::string sensor() const override { return sensor_; }
  std::vector<std::string> Assumptions() const override;

 private:
  // FailedPrecondition for a packet of another unit than that of the metadata.
  absl::Status CheckOrigin(absl::string_view packet);
  void AddColumn(absl::string_view packet, int column, const PacketLayout::Column& header,
                 int64_t time_ns);

  PacketLayout layout_;
  BeamGeometry geometry_;
  std::string sensor_;
  const PacketLayout::Origin told_;  // By the metadata.
  bool other_start_ = false;
  SensorClock clock_;
  ScanBuilder builder_;
  std::vector<bool> seen_;  // Columns of the frame.
  std::optional<uint16_t> frame_;
  std::optional<int64_t> last_time_ns_;
};

absl::Status OusterDecoder::Add(absl::string_view packet, int64_t arrival_ns,
                                std::vector<RecordedScan>* scans) {
  if (!layout_.Fits(packet)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a packet of ", packet.size(), " bytes is none of this sensor's, whose metadata tells of ",
        layout_.packet_bytes(), " bytes: is the metadata of another sensor or setting?"));
  }
  if (const absl::Status status = CheckOrigin(packet); !status.ok()) return status;
  for (int i = 0; i < layout_.columns(); ++i) {
    const PacketLayout::Column column = layout_.ColumnAt(packet, i);
    if (!column.valid || column.measurement >= seen_.size()) continue;
    if (column.timestamp_ns > INT64_MAX) continue;
    // A late column belongs to a scan that is gone.
    if (frame_ && static_cast<uint16_t>(column.frame + 1) == *frame_) continue;
    const int64_t time_ns = clock_.Read(static_cast<int64_t>(column.timestamp_ns), arrival_ns);
    const bool gap = last_time_ns_ && std::abs(time_ns - *last_time_ns_) > kLongestTurnNs;
    if ((frame_ && column.frame != *frame_) || gap) Flush(scans);
    frame_ = column.frame;
    last_time_ns_ = time_ns;
    if (!seen_[column.measurement]) AddColumn(packet, i, column, time_ns);
    seen_[column.measurement] = true;
  }
  return absl::OkStatus();
}

absl::Status OusterDecoder::CheckOrigin(absl::string_view packet) {
  const PacketLayout::Origin origin = layout_.OriginOf(packet);
  const bool serials = told_.serial != 0 && origin.serial != 0;
  const bool other_start =
      told_.start != 0 && origin.start != 0 && (told_.start & 0xFFFFFF) != origin.start;
  if (serials && told_.serial != origin.serial) {
    return absl::FailedPreconditionError(absl::StrCat(
        "the metadata are those of unit ", told_.serial, ", and the packets come from ",
        origin.serial, ", whose beams point elsewhere: give the JSON of that unit"));
  }
  if (other_start && !serials) {
    return absl::FailedPreconditionError(absl::StrCat(
        "the metadata are not of these packets, or were changed since: their initialization_id is ",
        told_.start, ", and that of the packets ", origin.start,
        ": give the JSON that was recorded with them"));
  }
  other_start_ |= other_start;
  return absl::OkStatus();
}

void OusterDecoder::AddColumn(absl::string_view packet, int column,
                              const PacketLayout::Column& header, int64_t time_ns) {
  for (int row = 0; row < layout_.rows(); ++row) {
    uint32_t first_range = 0;
    for (int which = 0; which < layout_.returns(); ++which) {
      const Pixel pixel = layout_.PixelAt(packet, column, row, which);
      if (pixel.range_mm == 0 || pixel.range_mm == first_range) continue;
      first_range = pixel.range_mm;
      const std::array<float, 3> at =
          geometry_.Locate(header.measurement, static_cast<size_t>(row), pixel.range_mm);
      const uint16_t intensity = layout_.has_signal() ? pixel.signal : pixel.reflectivity;
      char* more = builder_.Add(
          {at[0], at[1], at[2], static_cast<float>(intensity), static_cast<uint16_t>(row)},
          time_ns);
      codec::StoreAs(pixel.reflectivity, more);
      codec::StoreAs(pixel.range_mm, more + sizeof(pixel.reflectivity));
    }
  }
}

std::vector<std::string> OusterDecoder::Assumptions() const {
  std::vector<std::string> assumptions = {"scans are the sensor's frames"};
  if (other_start_) {
    assumptions.push_back("the metadata still hold since the sensor was started again");
  }
  if (!layout_.has_signal()) assumptions.push_back("the intensity is the reflectivity");
  if (layout_.returns() == 2) {
    assumptions.push_back(
        "both returns become points, the first before the second of each pixel; equal ones become "
        "one point");
  }
  if (const std::string clock = clock_.Description(); !clock.empty()) {
    assumptions.push_back(clock);
  }
  return assumptions;
}

}  // namespace

absl::StatusOr<std::unique_ptr<PacketDecoder>> MakeOusterDecoder(const std::string& metadata) {
  const absl::StatusOr<Metadata> parsed = ouster::ParseMetadata(metadata);
  if (!parsed.ok()) return parsed.status();
  return std::make_unique<OusterDecoder>(*parsed);
}

}  // namespace isthmus::readers
