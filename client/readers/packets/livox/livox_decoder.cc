#include <absl/strings/str_cat.h>

#include <cstdlib>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "client/readers/packets/limits.h"
#include "client/readers/packets/livox/livox_packet.h"
#include "client/readers/packets/packet_decoder.h"
#include "client/readers/packets/scan_builder.h"
#include "client/readers/packets/sensor_clock.h"
#include "core/codec/column.h"

namespace isthmus::readers {
namespace livox {
namespace {

// Nanoseconds from firing to firing before two packets tell: 240,000 a second.
constexpr int64_t kUsualIntervalNs = 4167;  // Format
constexpr int64_t kScanNs = 100'000'000;    // Format: of the maker's drivers.

class LivoxDecoder : public PacketDecoder {
 public:
  explicit LivoxDecoder(PacketOptions options)
      : options_(std::move(options)), clock_(0), builder_({{"tag", 0, ScalarType::kUint8}}) {}

  absl::Status Add(absl::string_view bytes, int64_t arrival_ns,
                   std::vector<RecordedScan>* scans) override;
  void Flush(std::vector<RecordedScan>* scans) override {
    if (!builder_.empty()) scans->push_back(builder_.Finish(clock_.offset_ns()));
  }
  std::string sensor() const override { return "livox"; }
  std::vector<std::string> Assumptions() const override;

 private:
  // From firing to firing: as the packet says, else as long as that before it took.
  int64_t IntervalOf(const Packet& packet, int64_t time_ns);

  const PacketOptions options_;
  SensorClock clock_;
  ScanBuilder builder_;
  std::optional<int64_t> last_time_ns_;  // The last packet's.
  int64_t interval_ns_ = kUsualIntervalNs;
};

int64_t LivoxDecoder::IntervalOf(const Packet& packet, int64_t time_ns) {
  const int64_t passed_ns = last_time_ns_ ? time_ns - *last_time_ns_ : 0;
  last_time_ns_ = time_ns;
  if (packet.interval_ns() > 0) return packet.interval_ns();
  const int64_t each_ns = passed_ns / static_cast<int64_t>(packet.firings());
  // More is a packet that was lost.
  if (each_ns > 0 && each_ns <= kLongestIntervalNs) interval_ns_ = each_ns;
  return interval_ns_;
}

absl::Status LivoxDecoder::Add(absl::string_view bytes, int64_t arrival_ns,
                               std::vector<RecordedScan>* scans) {
  const std::optional<Packet> packet = Packet::Parse(bytes);
  if (!packet) {
    return absl::InvalidArgumentError(
        absl::StrCat("a packet of ", bytes.size(), " bytes is none of Livox'"));
  }
  if (packet->firings() == 0) return absl::OkStatus();
  const int64_t packet_ns = clock_.Read(packet->time_ns(), arrival_ns);
  const int64_t interval_ns = IntervalOf(*packet, packet_ns);
  if (!builder_.empty()) {
    const int64_t passed_ns = packet_ns - builder_.first_ns();
    const bool full = builder_.size() + packet->firings() * packet->returns() > kMaxTurnPoints;
    if (full || ((passed_ns < 0 || passed_ns >= kScanNs) && !options_.by_flush)) Flush(scans);
  }
  for (size_t firing = 0; firing < packet->firings(); ++firing) {
    const int64_t time_ns = packet_ns + static_cast<int64_t>(firing) * interval_ns;
    for (size_t which = 0; which < packet->returns(); ++which) {
      const Point point = packet->PointAt(firing, which);
      if (point.x == 0 && point.y == 0 && point.z == 0) continue;
      char* more = builder_.Add(
          {point.x, point.y, point.z, static_cast<float>(point.reflectivity), 0}, time_ns);
      codec::StoreAs(point.tag, more);
    }
  }
  return absl::OkStatus();
}

std::vector<std::string> LivoxDecoder::Assumptions() const {
  std::vector<std::string> assumptions = {options_.by_flush ? "scans are the messages"
                                                            : "scans are cut each 100 ms"};
  if (std::string clock = clock_.Description(); !clock.empty()) {
    assumptions.push_back(std::move(clock));
  }
  return assumptions;
}

}  // namespace
}  // namespace livox

absl::StatusOr<std::unique_ptr<PacketDecoder>> MakeLivoxDecoder(const PacketOptions& options) {
  return std::make_unique<livox::LivoxDecoder>(options);
}

}  // namespace isthmus::readers
