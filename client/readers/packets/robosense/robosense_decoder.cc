#include <absl/strings/str_cat.h>

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/readers/packets/laser_geometry.h"
#include "client/readers/packets/limits.h"
#include "client/readers/packets/robosense/robosense_packet.h"
#include "client/readers/packets/turn_decoder.h"
#include "core/geometry/angles.h"

namespace isthmus::readers {
namespace robosense {
namespace {

class RobosenseDecoder : public TurnDecoder {
 public:
  explicit RobosenseDecoder(const PacketOptions& options) : TurnDecoder(options) {}

  absl::Status Add(absl::string_view bytes, int64_t arrival_ns,
                   std::vector<RecordedScan>* scans) override;
  std::vector<std::string> Assumptions() const override;

 private:
  // Blocks that share an azimuth, or one.
  struct Group {
    int first, blocks;
    int64_t time_ns;
    double step;  // Hundredths of a degree until the next group.
  };

  absl::Status SetUp(Model model);
  int64_t ReadClock(const Packet& packet, int64_t arrival_ns);
  std::vector<Group> GroupsOf(const Packet& packet, int64_t time_ns);
  void AddGroup(const Packet& packet, const Group& group);
  bool both() const { return both_returns_ && SpecOf(*model_).lasers == 16; }
  // Firings of all lasers in a block.
  int firings() const { return SpecOf(*model_).lasers == 16 && !both() ? 2 : 1; }

  std::string difop_;  // The newest.
  // Known from the first packet with points on.
  std::optional<Model> model_;
  std::string source_;
  std::optional<LaserGeometry> geometry_;
  bool both_returns_ = false;
  bool nanoseconds_ = false;  // The unit of the rest of a second.
  double step_ = 0;           // Hundredths of a degree, of the last group.
};

absl::Status RobosenseDecoder::SetUp(Model model) {
  absl::StatusOr<Calibration> calibration = FindAngles(options_.calibration, difop_, model);
  // Packets do not tell a Helios-16 from a Helios-32: the number of angles does.
  if (!calibration.ok() && model == Model::kHelios32) {
    absl::StatusOr<Calibration> of_16 = FindAngles(options_.calibration, difop_, Model::kHelios16);
    if (of_16.ok()) {
      model = Model::kHelios16;
      calibration = std::move(of_16);
    }
  }
  if (!calibration.ok()) return calibration.status();
  if (!difop_.empty()) both_returns_ = SendsBothReturns(difop_, model);
  calibration->range_unit_m = SpecOf(model).range_unit_m;
  model_ = model;
  source_ = calibration->source;
  geometry_.emplace(*calibration);
  return absl::OkStatus();
}

int64_t RobosenseDecoder::ReadClock(const Packet& packet, int64_t arrival_ns) {
  // Newer firmware counts nanoseconds, which are more than a second's microseconds.
  nanoseconds_ |= packet.rest() >= 1'000'000;
  return clock_.Read(packet.whole_ns() + packet.rest() * (nanoseconds_ ? 1 : 1000), arrival_ns);
}

std::vector<RobosenseDecoder::Group> RobosenseDecoder::GroupsOf(const Packet& packet,
                                                                int64_t time_ns) {
  const double block_ns = SpecOf(*model_).firing_us * firings() * 1e3;
  std::vector<Group> groups;
  for (int block = 0; block < packet.blocks(); ++block) {
    if (!groups.empty() && packet.azimuth(groups.back().first) == packet.azimuth(block)) {
      ++groups.back().blocks;
      continue;
    }
    double passed_ns = groups.empty() ? 0 : block_ns;
    if (!groups.empty()) {
      const int step = Turned(packet.azimuth(block) - packet.azimuth(groups.back().first));
      // More is a gap of the field of view, which takes as long as the turn.
      if (step <= kMaxAzimuthStep) step_ = step;
      if (step > kMaxAzimuthStep && step_ > 0) passed_ns = step / step_ * block_ns;
      groups.back().step = step_;
      time_ns = groups.back().time_ns + std::llround(passed_ns);
    }
    groups.push_back({block, 1, time_ns, step_});
  }
  if (!groups.empty()) groups.back().step = step_;
  return groups;
}

void RobosenseDecoder::AddGroup(const Packet& packet, const Group& group) {
  const Spec& spec = SpecOf(*model_);
  for (int block = group.first; block < group.first + group.blocks; ++block) {
    for (int channel = 0; channel < spec.channels; ++channel) {
      const uint16_t range = packet.range(block, channel);
      bool wanted = range != 0;
      for (int other = group.first; other < block; ++other) {
        wanted = wanted && packet.range(other, channel) != range;
      }
      if (both() && channel >= 16) wanted = wanted && packet.range(block, channel - 16) != range;
      if (!wanted) continue;
      const double after_us = ChannelTimeUs(*model_, channel, both());
      const double azimuth =
          packet.azimuth(block) + group.step * after_us / (spec.firing_us * firings());
      const LaserGeometry::Position at =
          geometry_->Locate(static_cast<size_t>(channel % spec.lasers), azimuth, range,
                            packet.intensity(block, channel));
      const double angle = azimuth * kRadPerDeg / 100;
      builder_.Add(
          {at.x + static_cast<float>(spec.lens_m * std::cos(angle)),
           at.y - static_cast<float>(spec.lens_m * std::sin(angle)), at.z, at.intensity, at.ring},
          group.time_ns + std::llround(after_us * 1e3));
    }
  }
}

absl::Status RobosenseDecoder::Add(absl::string_view bytes, int64_t arrival_ns,
                                   std::vector<RecordedScan>* scans) {
  if (IsDifop(bytes)) {
    difop_ = std::string(bytes);
    if (model_) both_returns_ = SendsBothReturns(difop_, *model_);
    return absl::OkStatus();
  }
  const absl::StatusOr<Packet> packet = Packet::Parse(bytes);
  if (!packet.ok()) return packet.status();
  if (!model_) {
    if (const absl::Status status = SetUp(packet->model()); !status.ok()) return status;
  }
  const bool same = packet->model() == *model_ ||
                    (packet->model() == Model::kHelios32 && *model_ == Model::kHelios16);
  if (!same) {
    return absl::InvalidArgumentError(absl::StrCat("a packet of a ", SpecOf(packet->model()).name,
                                                   " comes among those of a ",
                                                   SpecOf(*model_).name));
  }
  const int64_t packet_ns = ReadClock(*packet, arrival_ns);
  if (cutter_.MissesATurn(packet->azimuth(0), packet_ns)) Flush(scans);
  for (const Group& group : GroupsOf(*packet, packet_ns)) {
    const auto points =
        static_cast<size_t>(SpecOf(*model_).channels) * static_cast<size_t>(group.blocks);
    if (cutter_.EndsBefore(packet->azimuth(group.first), group.time_ns, builder_, points)) {
      Flush(scans);
    }
    AddGroup(*packet, group);
  }
  return absl::OkStatus();
}

std::vector<std::string> RobosenseDecoder::Assumptions() const {
  std::vector<std::string> assumptions;
  if (!geometry_) return assumptions;
  assumptions.push_back(
      absl::StrCat("packets are those of a ", SpecOf(*model_).name, ", placed by ", source_));
  assumptions.push_back(cutter_.Description());
  assumptions.push_back(clock_.Description());
  return assumptions;
}

}  // namespace
}  // namespace robosense

absl::StatusOr<std::unique_ptr<PacketDecoder>> MakeRobosenseDecoder(const PacketOptions& options) {
  return std::make_unique<robosense::RobosenseDecoder>(options);
}

}  // namespace isthmus::readers
