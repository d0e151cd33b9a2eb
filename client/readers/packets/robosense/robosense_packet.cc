#include "client/readers/packets/robosense/robosense_packet.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <chrono>
#include <optional>
#include <string>

#include "client/readers/packets/robosense/robosense_bytes.h"
#include "core/nanoseconds.h"

namespace isthmus::readers::robosense {
namespace {

constexpr absl::string_view kOldId("\x55\xAA\x05\x0A\x5A\xA5\x50\xA0", 8);  // Format: RS-16, RS-32
constexpr absl::string_view kNewId("\x55\xAA\x05\x5A", 4);                  // Format
constexpr size_t kTypeAt = 30;                     // Format: 1 for an RS-16.
constexpr size_t kRuby80Next = 80 + 4 + 80 * 3;    // Format: of its second block.
constexpr size_t kRuby128Next = 80 + 4 + 128 * 3;  // Format

constexpr Spec kSpecs[] = {
    {"RS-LiDAR-16", 16, 12, 32, 42, 0.005, 0.03825, 55.5},
    {"RS-LiDAR-32", 32, 12, 32, 42, 0.005, 0.03997, 55.52},
    {"Helios-16", 16, 12, 32, 42, 0.0025, 0.03498, 55.56},
    {"Helios-32", 32, 12, 32, 42, 0.0025, 0.03498, 55.56},
    {"Ruby-80", 80, 4, 80, 80, 0.005, 0.03615, 55.552},
    {"Ruby-128", 128, 3, 128, 80, 0.005, 0.03615, 55.55},
};

// Microseconds, by laser, RS-LiDAR-32; and in steps of 3.236, of the Ruby-80.
constexpr double kRs32Times[] = {0.00,  2.88,  5.76,  8.64,  11.52, 14.40, 17.28, 20.16,
                                 23.04, 25.92, 28.80, 31.68, 34.56, 37.44, 40.32, 44.64,
                                 1.44,  4.32,  7.20,  10.08, 12.96, 15.84, 18.72, 21.60,
                                 24.48, 27.36, 30.24, 33.12, 36.00, 38.88, 41.76, 46.08};
constexpr int kRuby80Steps[] = {0,  0,  0,  1,  1,  2,  2,  2,  2,  3,  3,  3,  4,  4,  4,  5,
                                5,  5,  6,  6,  6,  7,  7,  8,  8,  9,  9,  10, 10, 11, 11, 12,
                                12, 13, 13, 14, 14, 15, 15, 15, 0,  0,  0,  1,  1,  1,  2,  2,
                                2,  3,  3,  4,  4,  4,  4,  5,  5,  6,  6,  6,  7,  7,  7,  8,
                                8,  9,  9,  10, 10, 11, 11, 11, 12, 12, 13, 14, 14, 15, 15, 15};
constexpr double kRubyStepUs = 3.236;  // Format

// Blocks begin with FF EE, those of a Ruby with FE and the number of the return.
bool IsRuby(Model model) { return model == Model::kRuby80 || model == Model::kRuby128; }

std::optional<Model> ModelOf(absl::string_view bytes) {
  if (absl::StartsWith(bytes, kOldId)) {
    return ByteAt(bytes, kTypeAt) == 1 ? Model::kRs16 : Model::kRs32;
  }
  if (!absl::StartsWith(bytes, kNewId)) return std::nullopt;
  if (BigAt16(bytes, 42) == 0xFFEE) return Model::kHelios32;
  if (ByteAt(bytes, 80) != 0xFE) return std::nullopt;
  if (ByteAt(bytes, kRuby80Next) == 0xFE) return Model::kRuby80;
  if (ByteAt(bytes, kRuby128Next) == 0xFE) return Model::kRuby128;
  return std::nullopt;
}

}  // namespace

const Spec& SpecOf(Model model) { return kSpecs[static_cast<size_t>(model)]; }

double ChannelTimeUs(Model model, int channel, bool both) {
  switch (model) {
    case Model::kRs16:
      return channel % 16 * 2.8 + (channel < 16 || both ? 0 : 55.5);
    case Model::kRs32:
      return kRs32Times[channel];
    case Model::kHelios16:
      return (both ? channel % 16 : channel) * 1.73;
    case Model::kHelios32:
      return channel * 1.73;
    case Model::kRuby80:
      return kRuby80Steps[channel] * kRubyStepUs;
    case Model::kRuby128:
      break;
  }
  return channel % 64 / 4 * kRubyStepUs;
}

absl::StatusOr<Packet> Packet::Parse(absl::string_view bytes) {
  if (!MayBeRobosensePacket(bytes, bytes.size())) {
    return absl::InvalidArgumentError(
        absl::StrCat("a packet of ", bytes.size(), " bytes is none of RoboSense's"));
  }
  const std::optional<Model> model = ModelOf(bytes);
  if (!model) {
    return absl::InvalidArgumentError(
        "packets of this RoboSense sensor cannot be read, only those of RS-LiDAR-16, RS-LiDAR-32, "
        "Helios and Ruby; for other sensors record the driver's clouds");
  }
  Packet packet;
  packet.bytes_ = bytes;
  packet.model_ = *model;
  // A block that does not begin as one, and all behind it, is empty.
  for (int block = 0; block < SpecOf(*model).blocks; ++block) {
    const uint16_t flag = BigAt16(bytes, packet.BlockAt(block));
    if (IsRuby(*model) ? flag >> 8 != 0xFE : flag != 0xFFEE) break;
    if (packet.azimuth(block) >= kTurn) {
      return absl::InvalidArgumentError(
          "a packet of RoboSense's has an azimuth beyond 360 degrees");
    }
    packet.blocks_ = block + 1;
  }
  if (packet.blocks_ == 0) {
    return absl::InvalidArgumentError("a packet of RoboSense's holds no block of points");
  }
  return packet;
}

size_t Packet::BlockAt(int block) const {
  const Spec& spec = SpecOf(model_);
  return spec.first_at + static_cast<size_t>(block * (4 + 3 * spec.channels));
}

int Packet::azimuth(int block) const { return BigAt16(bytes_, BlockAt(block) + 2); }

uint16_t Packet::range(int block, int channel) const {
  return BigAt16(bytes_, BlockAt(block) + 4 + static_cast<size_t>(channel) * 3);
}

uint8_t Packet::intensity(int block, int channel) const {
  return ByteAt(bytes_, BlockAt(block) + 6 + static_cast<size_t>(channel) * 3);
}

int64_t Packet::whole_ns() const {
  if (model_ == Model::kRs16 || model_ == Model::kRs32) {
    const std::chrono::year_month_day date{std::chrono::year(2000 + ByteAt(bytes_, 20)),
                                           std::chrono::month(ByteAt(bytes_, 21)),
                                           std::chrono::day(ByteAt(bytes_, 22))};
    if (!date.ok()) return 0;
    const int64_t days = std::chrono::sys_days(date).time_since_epoch().count();
    return (days * 86400 + ByteAt(bytes_, 23) * 3600 + ByteAt(bytes_, 24) * 60 +
            ByteAt(bytes_, 25)) *
           kNsPerSecond;
  }
  // Six bytes of seconds, of which the first two are 0 until 2106.
  return int64_t{BigAt32(bytes_, IsRuby(model_) ? 12 : 22)} * kNsPerSecond;
}

int64_t Packet::rest() const {
  if (model_ == Model::kRs16 || model_ == Model::kRs32) {
    return BigAt16(bytes_, 26) * 1000 + BigAt16(bytes_, 28);
  }
  return BigAt32(bytes_, IsRuby(model_) ? 16 : 26);
}

bool MayBeRobosensePacket(absl::string_view beginning, size_t length) {
  return length == kPacketBytes &&
         (absl::StartsWith(beginning, kOldId) || absl::StartsWith(beginning, kNewId));
}

}  // namespace isthmus::readers::robosense
