// A LiDAR packet of an Ouster sensor: columns of pixels, in the layout of its UDP profile.
// Ouster Firmware User Manual v2.5, "LiDAR Data Packet Format", and v2.1, "LiDAR Data Format"
// (LEGACY).
#pragma once

#include <absl/strings/string_view.h>

#include <cstddef>
#include <cstdint>

#include "client/readers/packets/ouster/ouster_metadata.h"
#include "core/codec/column.h"

namespace isthmus::readers::ouster {

struct Pixel {
  uint32_t range_mm = 0;  // 0: no return.
  uint16_t reflectivity = 0;
  uint16_t signal = 0;  // Photons; 0 in the profile without.
  uint16_t near_ir = 0;
};

// The layout of the packets of one sensor. Immutable.
class PacketLayout {
 public:
  explicit PacketLayout(const Metadata& metadata);

  size_t packet_bytes() const { return packet_bytes_; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  int returns() const { return profile_ == Profile::kDual ? 2 : 1; }
  bool has_signal() const { return profile_ != Profile::kLowRate; }

  // True if this can be a packet of the sensor, by its size and type.
  bool Fits(absl::string_view packet) const;

  // The unit that sent a packet that fits, and the number of its start; zeros in profile LEGACY.
  struct Origin {
    uint64_t serial;
    uint32_t start;
  };
  Origin OriginOf(absl::string_view packet) const;

  // A column of a packet that fits. `column` counts in the packet from 0, `row` from the top beam.
  struct Column {
    uint64_t timestamp_ns;
    uint16_t measurement;  // Its place in the frame.
    uint16_t frame;
    bool valid;
  };
  Column ColumnAt(absl::string_view packet, int column) const;
  Pixel PixelAt(absl::string_view packet, int column, int row, int which_return) const;

 private:
  const char* StartOf(absl::string_view packet, int column) const {
    return packet.data() + header_bytes_ + static_cast<size_t>(column) * column_bytes_;
  }

  Profile profile_;
  int columns_, rows_;
  size_t header_bytes_, column_header_bytes_, pixel_bytes_, column_bytes_, packet_bytes_;
};

// True if the datagram may hold Ouster's LiDAR data, of any sensor: by the sizes that packets of 16
// columns have, and their first bytes. `beginning` may be cut.
bool MayBeOusterPacket(absl::string_view beginning, size_t length);

}  // namespace isthmus::readers::ouster
