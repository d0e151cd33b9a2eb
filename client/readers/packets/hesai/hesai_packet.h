// A data packet of a Hesai sensor: blocks of measurements, the clock, and how they were made.
// Pandar40P, Pandar64, PandarQT, PandarXT, QT128C2X and OT128 User Manuals, "Point Cloud Data
// Packet".
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstddef>
#include <cstdint>

#include "client/readers/packets/hesai/hesai_model.h"
#include "core/codec/column.h"

namespace isthmus::readers::hesai {

// A view of a packet, good as long as its bytes.
class Packet {
 public:
  // InvalidArgument, saying why, for what is no packet of a sensor that is known.
  static absl::StatusOr<Packet> Parse(absl::string_view bytes);

  Model model() const { return model_; }
  int lasers() const { return lasers_; }
  int blocks() const { return blocks_; }
  double range_unit_m() const { return range_unit_m_; }

  // Hundredths of a degree, below 36000.
  int azimuth(int block) const { return Load<uint16_t>(BlockAt(block)); }
  // In units of range_unit_m; 0: no return.
  uint16_t range(int block, int laser) const { return Load<uint16_t>(UnitAt(block, laser)); }
  uint8_t reflectivity(int block, int laser) const {
    return Load<uint8_t>(UnitAt(block, laser) + 2);
  }

  // Nanoseconds since the Unix epoch, if the sensor's clock is set.
  int64_t time_ns() const;
  FiringState StateOf(int block) const;

 private:
  explicit Packet(absl::string_view bytes) : bytes_(bytes) {}

  size_t BlockAt(int block) const { return first_at_ + static_cast<size_t>(block) * block_bytes_; }
  size_t UnitAt(int block, int laser) const {
    return BlockAt(block) + 2 + static_cast<size_t>(laser) * unit_bytes_;
  }
  template <typename T>
  T Load(size_t at) const {
    return codec::LoadAs<T>(bytes_.data() + at);
  }

  absl::string_view bytes_;
  Model model_ = Model::kPandar40P;
  int lasers_ = 0, blocks_ = 0, returns_ = 1;
  double range_unit_m_ = 0.004;
  // The first azimuth begins at first_at_, the next one block_bytes_ behind it; a measurement has
  // unit_bytes_.
  size_t first_at_ = 0, block_bytes_ = 0, unit_bytes_ = 0;
  size_t tail_at_ = 0, date_at_ = 0, microseconds_at_ = 0;
};

// True if the datagram may hold point data of Hesai's, of any sensor. `beginning` may be cut.
bool MayBeHesaiPacket(absl::string_view beginning, size_t length);

}  // namespace isthmus::readers::hesai
