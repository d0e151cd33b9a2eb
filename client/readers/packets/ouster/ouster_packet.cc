#include "client/readers/packets/ouster/ouster_packet.h"

namespace isthmus::readers::ouster {
namespace {

using codec::LoadAs;

// Bytes before the columns, behind them, before the pixels of each, and of each pixel; behind a
// column of the legacy profile there is a word with its status.
struct ProfileLayout {
  size_t header, footer, column_header, column_footer, pixel;
};

ProfileLayout LayoutOf(Profile profile) {
  switch (profile) {
    case Profile::kLegacy:
      return {0, 0, 16, 4, 12};
    case Profile::kSingle:
      return {32, 32, 12, 0, 12};
    case Profile::kDual:
      return {32, 32, 12, 0, 16};
    case Profile::kLowRate:
      break;
  }
  return {32, 32, 12, 0, 4};
}

size_t ColumnBytes(const ProfileLayout& layout, int rows) {
  return layout.column_header + static_cast<size_t>(rows) * layout.pixel + layout.column_footer;
}

size_t PacketBytes(const ProfileLayout& layout, int columns, int rows) {
  return layout.header + static_cast<size_t>(columns) * ColumnBytes(layout, rows) + layout.footer;
}

constexpr uint16_t kLidarPacket = 1;           // Format
constexpr uint32_t kLegacyValid = 0xFFFFFFFF;  // Format
constexpr uint32_t kRange20 = 0xFFFFF;         // Format: LEGACY
constexpr uint32_t kRange19 = 0x7FFFF;         // Format: RNG19
constexpr uint16_t kRange15 = 0x7FFF;          // Format: RNG15, of 8 mm
constexpr int kUsualColumns = 16;              // Format

bool IsLidarType(absl::string_view packet) {
  return packet.size() >= 2 && LoadAs<uint16_t>(packet.data()) == kLidarPacket;
}

}  // namespace

PacketLayout::PacketLayout(const Metadata& metadata)
    : profile_(metadata.profile),
      columns_(metadata.columns_per_packet),
      rows_(metadata.pixels_per_column) {
  const ProfileLayout layout = LayoutOf(profile_);
  header_bytes_ = layout.header;
  column_header_bytes_ = layout.column_header;
  pixel_bytes_ = layout.pixel;
  column_bytes_ = ColumnBytes(layout, rows_);
  packet_bytes_ = PacketBytes(layout, columns_, rows_);
}

bool PacketLayout::Fits(absl::string_view packet) const {
  if (packet.size() != packet_bytes_) return false;
  return profile_ == Profile::kLegacy || IsLidarType(packet);
}

PacketLayout::Origin PacketLayout::OriginOf(absl::string_view packet) const {
  if (profile_ == Profile::kLegacy) return {0, 0};
  // 24 bits from byte 4 on, then 40.
  return {LoadAs<uint64_t>(packet.data() + 4) >> 24 & 0xFFFFFFFFFF,
          LoadAs<uint32_t>(packet.data() + 4) & 0xFFFFFF};
}

PacketLayout::Column PacketLayout::ColumnAt(absl::string_view packet, int column) const {
  const char* start = StartOf(packet, column);
  Column result;
  result.timestamp_ns = LoadAs<uint64_t>(start);
  result.measurement = LoadAs<uint16_t>(start + 8);
  if (profile_ == Profile::kLegacy) {
    result.frame = LoadAs<uint16_t>(start + 10);
    result.valid = LoadAs<uint32_t>(start + column_bytes_ - 4) == kLegacyValid;
  } else {
    result.frame = LoadAs<uint16_t>(packet.data() + 2);
    result.valid = (LoadAs<uint16_t>(start + 10) & 1) != 0;
  }
  return result;
}

Pixel PacketLayout::PixelAt(absl::string_view packet, int column, int row, int which_return) const {
  const char* at =
      StartOf(packet, column) + column_header_bytes_ + static_cast<size_t>(row) * pixel_bytes_;
  Pixel pixel;
  switch (profile_) {
    case Profile::kLegacy:
      pixel.range_mm = LoadAs<uint32_t>(at) & kRange20;
      pixel.reflectivity = LoadAs<uint16_t>(at + 4);
      pixel.signal = LoadAs<uint16_t>(at + 6);
      pixel.near_ir = LoadAs<uint16_t>(at + 8);
      break;
    case Profile::kSingle:
      pixel.range_mm = LoadAs<uint32_t>(at) & kRange19;
      pixel.reflectivity = LoadAs<uint8_t>(at + 4);
      pixel.signal = LoadAs<uint16_t>(at + 6);
      pixel.near_ir = LoadAs<uint16_t>(at + 8);
      break;
    case Profile::kDual:
      pixel.range_mm = LoadAs<uint32_t>(at + 4 * which_return) & kRange19;
      pixel.reflectivity = LoadAs<uint8_t>(at + 4 * which_return + 3);
      pixel.signal = LoadAs<uint16_t>(at + 8 + 2 * which_return);
      pixel.near_ir = LoadAs<uint16_t>(at + 12);
      break;
    case Profile::kLowRate:
      pixel.range_mm = (LoadAs<uint16_t>(at) & kRange15) * 8u;
      pixel.reflectivity = LoadAs<uint8_t>(at + 2);
      pixel.near_ir = static_cast<uint16_t>(LoadAs<uint8_t>(at + 3) << 4);
      break;
  }
  return pixel;
}

bool MayBeOusterPacket(absl::string_view beginning, size_t length) {
  for (const Profile profile :
       {Profile::kLegacy, Profile::kSingle, Profile::kDual, Profile::kLowRate}) {
    for (const int rows : {16, 32, 64, 128}) {
      if (length != PacketBytes(LayoutOf(profile), kUsualColumns, rows)) continue;
      // The first column's number is a multiple of the packet's.
      const bool first = profile == Profile::kLegacy && beginning.size() >= 10 &&
                         LoadAs<uint16_t>(beginning.data() + 8) % kUsualColumns == 0;
      if (first || (profile != Profile::kLegacy && IsLidarType(beginning))) return true;
    }
  }
  return false;
}

}  // namespace isthmus::readers::ouster
