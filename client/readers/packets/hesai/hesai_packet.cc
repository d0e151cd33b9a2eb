#include "client/readers/packets/hesai/hesai_packet.h"

#include <absl/strings/str_cat.h>

#include <chrono>

#include "core/codec/column.h"

namespace isthmus::readers::hesai {
namespace {

// The places of the return mode, date and microseconds in the tail, which follows the blocks.
struct Tail {
  size_t bytes, return_mode, date, microseconds;
};
constexpr Tail kOldTail = {22, 14, 16, 10};   // Format: Pandar40P, Pandar64
constexpr Tail kQt64Tail = {24, 16, 18, 12};  // Format
constexpr Tail kXtTail = {24, 10, 13, 19};    // Format
constexpr Tail k128Tail = {26, 12, 15, 21};   // Format: QT128, OT128
constexpr size_t kAzimuthStateAt = 9;         // Format: OT128
constexpr size_t kOperationAt = 11;           // Format: OT128
constexpr size_t kLoopAt = 5;                 // Format: QT128
constexpr size_t kFlagsAt = 11;               // Format: of the header of 12 bytes.
constexpr uint8_t kHasSafety = 0x04;          // Format
constexpr uint8_t kHasConfidence = 0x10;      // Format

uint8_t Byte(absl::string_view bytes, size_t at) { return static_cast<uint8_t>(bytes[at]); }

bool Begins(absl::string_view bytes, uint8_t first, uint8_t second) {
  return bytes.size() > 1 && Byte(bytes, 0) == first && Byte(bytes, 1) == second;
}

// The layout that a header of 12 bytes tells.
struct Layout {
  Model model;
  int lasers, blocks;
  size_t unit_bytes, behind_blocks;  // behind_blocks: checksums before the tail.
  Tail tail;
};

absl::StatusOr<Layout> LayoutOf(absl::string_view bytes) {
  const int major = Byte(bytes, 2), minor = Byte(bytes, 3);
  const int lasers = Byte(bytes, 6), blocks = Byte(bytes, 7);
  const uint8_t flags = Byte(bytes, kFlagsAt);
  const size_t safety = (flags & kHasSafety) != 0 ? 17 : 0;
  if (lasers == 16 && blocks == 8) return Layout{Model::kPandarXt16, 16, 8, 4, 0, kXtTail};
  if (lasers == 32 && blocks == 8) return Layout{Model::kPandarXt32, 32, 8, 4, 0, kXtTail};
  if (lasers == 32 && blocks == 6) return Layout{Model::kPandarXt32M, 32, 6, 4, 0, kXtTail};
  if (lasers == 64 && blocks == 4) return Layout{Model::kPandarQt64, 64, 4, 4, 0, kQt64Tail};
  if (lasers == 128 && blocks == 2 && (major == 1 || major == 3)) {
    const Model model = major == 1 ? Model::kOt128 : Model::kPandarQt128;
    const size_t unit = (flags & kHasConfidence) != 0 ? 4 : 3;
    return Layout{model, 128, 2, unit, 4 + safety, k128Tail};
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "packets of Hesai's protocol ", major, ".", minor, " with ", lasers, " lasers and ", blocks,
      " blocks cannot be read, only those of Pandar40P, Pandar64, QT64, QT128, XT16, XT32, XT32M, "
      "OT128 and Pandar128; for other sensors record the driver's clouds"));
}

int ReturnsOf(uint8_t mode) {
  if (mode == 0x3D) return 3;                                     // Format
  return mode == 0x03 || (mode >= 0x39 && mode <= 0x3C) ? 2 : 1;  // Format
}

bool IsPandar40P(absl::string_view beginning, size_t length) {
  return (length == 1262 || length == 1266) && Begins(beginning, 0xFF, 0xEE);
}

bool IsPandar64(absl::string_view beginning, size_t length) {
  return (length == 1194 || length == 1198) && Begins(beginning, 0xEE, 0xFF) &&
         beginning.size() > 3 && Byte(beginning, 2) == 64 && Byte(beginning, 3) == 6;
}

}  // namespace

absl::StatusOr<Packet> Packet::Parse(absl::string_view bytes) {
  if (!MayBeHesaiPacket(bytes, bytes.size())) {
    return absl::InvalidArgumentError(
        absl::StrCat("a packet of ", bytes.size(), " bytes is none of Hesai's"));
  }
  Packet packet(bytes);
  Layout layout = {Model::kPandar40P, 40, 10, 3, 0, kOldTail};
  packet.first_at_ = 2;
  if (IsPandar64(bytes, bytes.size())) {
    layout = {Model::kPandar64, 64, 6, 3, 0, kOldTail};
    packet.first_at_ = 8;
  } else if (!IsPandar40P(bytes, bytes.size())) {
    const absl::StatusOr<Layout> told = LayoutOf(bytes);
    if (!told.ok()) return told.status();
    layout = *told;
    packet.first_at_ = 12;
    packet.range_unit_m_ = Byte(bytes, 9) * 1e-3;
  }
  packet.model_ = layout.model;
  packet.lasers_ = layout.lasers;
  packet.blocks_ = layout.blocks;
  packet.unit_bytes_ = layout.unit_bytes;
  const bool flagged = layout.model == Model::kPandar40P;  // Each block begins with FF EE.
  packet.block_bytes_ =
      2 + static_cast<size_t>(layout.lasers) * layout.unit_bytes + (flagged ? 2 : 0);
  packet.tail_at_ = packet.BlockAt(layout.blocks) - (flagged ? 2 : 0) + layout.behind_blocks;
  packet.date_at_ = packet.tail_at_ + layout.tail.date;
  packet.microseconds_at_ = packet.tail_at_ + layout.tail.microseconds;
  if (bytes.size() < packet.tail_at_ + layout.tail.bytes || packet.range_unit_m_ == 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("a packet of ", bytes.size(), " bytes is cut: a ", NameOf(layout.model),
                     " sends ", packet.tail_at_ + layout.tail.bytes, " and more"));
  }
  packet.returns_ = ReturnsOf(Byte(bytes, packet.tail_at_ + layout.tail.return_mode));
  if (packet.blocks_ % packet.returns_ != 0) packet.returns_ = 1;
  for (int block = 0; block < packet.blocks_; ++block) {
    const bool flag_fits = !flagged || Begins(bytes.substr(packet.BlockAt(block) - 2), 0xFF, 0xEE);
    if (!flag_fits || packet.azimuth(block) >= kTurn) {
      return absl::InvalidArgumentError(
          "a packet of Hesai's is damaged: a block has another flag or an azimuth beyond 360 "
          "degrees");
    }
  }
  return packet;
}

int64_t Packet::time_ns() const {
  const int64_t fraction_ns = int64_t{Load<uint32_t>(microseconds_at_)} * 1000;
  // Newer ones with a year of 0 have seconds instead of a date, the most significant byte first.
  const uint8_t year = Byte(bytes_, date_at_);
  if (year == 0) {
    int64_t seconds = 0;
    for (size_t i = 1; i < 6; ++i) seconds = seconds << 8 | Byte(bytes_, date_at_ + i);
    return (seconds & 0xFFFFFFFF) * 1'000'000'000 + fraction_ns;
  }
  // Some count years from 1900, some from 2000.
  const std::chrono::year_month_day date{std::chrono::year(year < 100 ? 2000 + year : 1900 + year),
                                         std::chrono::month(Byte(bytes_, date_at_ + 1)),
                                         std::chrono::day(Byte(bytes_, date_at_ + 2))};
  if (!date.ok()) return fraction_ns;
  const int64_t days = std::chrono::sys_days(date).time_since_epoch().count();
  const int64_t seconds = days * 86400 + Byte(bytes_, date_at_ + 3) * 3600 +
                          Byte(bytes_, date_at_ + 4) * 60 + Byte(bytes_, date_at_ + 5);
  return seconds * 1'000'000'000 + fraction_ns;
}

FiringState Packet::StateOf(int block) const {
  FiringState state;
  state.returns = returns_;
  if (model_ == Model::kOt128) {
    state.high_res = (Load<uint8_t>(tail_at_ + kOperationAt) & 0x0F) == 0;
    state.azimuth_state = Load<uint16_t>(tail_at_ + kAzimuthStateAt) >> (14 - 2 * block) & 3;
  }
  if (model_ == Model::kPandarQt128) {
    state.first_loop = (Load<uint8_t>(tail_at_ + kLoopAt) & 1) != 0;
  }
  return state;
}

bool MayBeHesaiPacket(absl::string_view beginning, size_t length) {
  if (IsPandar40P(beginning, length) || IsPandar64(beginning, length)) return true;
  // A header of 12 bytes: a version, lasers, blocks, and a unit of ranges.
  return length > 500 && beginning.size() >= 12 && Begins(beginning, 0xEE, 0xFF) &&
         Byte(beginning, 2) > 0 && Byte(beginning, 2) < 10 && Byte(beginning, 6) > 0 &&
         Byte(beginning, 7) > 0 && Byte(beginning, 9) > 0;
}

}  // namespace isthmus::readers::hesai
