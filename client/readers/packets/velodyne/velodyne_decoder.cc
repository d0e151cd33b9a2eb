#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include "client/readers/packets/laser_geometry.h"
#include "client/readers/packets/limits.h"
#include "client/readers/packets/turn_decoder.h"
#include "client/readers/packets/velodyne/velodyne_calibration.h"
#include "client/readers/packets/velodyne/velodyne_model.h"
#include "client/readers/packets/velodyne/velodyne_packet.h"
#include "core/nanoseconds.h"

namespace isthmus::readers {
namespace {

using velodyne::kBlocks;
using velodyne::kLasersPerBlock;
using velodyne::Model;
using velodyne::Packet;

class VelodyneDecoder : public TurnDecoder {
 public:
  VelodyneDecoder(const PacketOptions& options, std::optional<Model> model,
                  std::optional<Calibration> given)
      : TurnDecoder(options, kNsPerHour, options.utc_offset_ns),
        wanted_(model),
        given_(std::move(given)) {}

  absl::Status Add(absl::string_view bytes, int64_t arrival_ns,
                   std::vector<RecordedScan>* scans) override;
  std::string sensor() const override {
    if (setup_) return velodyne::SensorName(setup_->model);
    return wanted_ ? velodyne::SensorName(*wanted_) : "";
  }
  std::vector<std::string> Assumptions() const override;

 private:
  // Follows from the model.
  struct Setup {
    Model model;
    std::string calibration;
    LaserGeometry geometry;
    velodyne::FiringTimes single, dual;
  };

  absl::Status SetUp(const Packet& packet);
  // The firings of a packet.
  struct Firing {
    bool dual;
    int blocks;  // Per firing.
    const velodyne::FiringTimes& times;
    int64_t time_ns;
  };
  double SpeedAt(const Packet& packet, int block, const Firing& firing);
  // Time that lasers were dark before a block: a sensor with a limited field of view fills a packet
  // with its view before and behind the rest of the turn. Nanoseconds.
  int64_t DarkTimeBefore(const Packet& packet, int block, const Firing& firing) const;
  void AddBlock(const Packet& packet, int block, double speed, const Firing& firing);

  const std::optional<Model> wanted_;
  const std::optional<Calibration> given_;
  std::optional<Setup> setup_;
  double last_speed_ = 0;  // Hundredths of a degree per microsecond.
  bool saw_dual_ = false;
};

absl::Status VelodyneDecoder::SetUp(const Packet& packet) {
  const std::optional<Model> model = wanted_ ? wanted_ : velodyne::ModelOf(packet);
  if (!model) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "packets of Velodyne's product 0x%02x are not known: name the sensor (vlp16, vlp32, "
        "hdl32, hdl64 or vls128) if it sends like one of these",
        packet.product()));
  }
  const std::optional<Calibration> calibration =
      given_ ? given_ : velodyne::ManualCalibration(*model);
  if (const absl::Status status = velodyne::CheckCalibration(*model, calibration); !status.ok()) {
    return absl::FailedPreconditionError(status.message());
  }
  setup_.emplace(Setup{*model, calibration->source, LaserGeometry(*calibration),
                       velodyne::TimesOf(*model, false), velodyne::TimesOf(*model, true)});
  return absl::OkStatus();
}

double VelodyneDecoder::SpeedAt(const Packet& packet, int block, const Firing& firing) {
  // The next packet may be lost: the last firing turns as fast as the one before it, and where a
  // packet is one firing, as fast as from the packet before.
  if (firing.blocks == packet.blocks()) last_speed_ = cutter_.speed() * 1e3;
  const int next = block + firing.blocks;
  if (next < packet.blocks()) {
    const int step = Turned(packet.azimuth(next) - packet.azimuth(block));
    const double passed_us = firing.times[next][0] - firing.times[block][0];
    if (step <= kMaxAzimuthStep) last_speed_ = step / passed_us;
  }
  return last_speed_;
}

int64_t VelodyneDecoder::DarkTimeBefore(const Packet& packet, int block,
                                        const Firing& firing) const {
  if (block == 0 || last_speed_ == 0) return 0;
  const int before = block - firing.blocks;
  const int step = Turned(packet.azimuth(block) - packet.azimuth(before));
  if (step <= kMaxAzimuthStep || step > kTurn - kMaxAzimuthStep) return 0;
  const double passed_us = firing.times[block][0] - firing.times[before][0];
  return std::llround((step / last_speed_ - passed_us) * 1e3);
}

void VelodyneDecoder::AddBlock(const Packet& packet, int block, double speed,
                               const Firing& firing) {
  const std::array<double, kLasersPerBlock>& times = firing.times[block];
  const int azimuth = packet.azimuth(block);
  const double start_us = firing.times[block - block % firing.blocks][0];
  const int first = packet.bank(block).value_or(0) * kLasersPerBlock;
  const int lasers = velodyne::Lasers(setup_->model);
  const int other = velodyne::BlocksToOtherReturn(setup_->model);
  const bool second = firing.dual && block / other % 2 == 1;
  for (int i = 0; i < kLasersPerBlock; ++i) {
    const uint16_t range = packet.range(block, i);
    if (range == 0) continue;
    if (second && range == packet.range(block - other, i)) continue;
    const double behind_us = times[i] - start_us;
    const LaserGeometry::Position at =
        setup_->geometry.Locate(static_cast<size_t>((first + i) % lasers),
                                azimuth + speed * behind_us, range, packet.reflectivity(block, i));
    builder_.Add({at.x, at.y, at.z, at.intensity, at.ring},
                 firing.time_ns + static_cast<int64_t>(std::lround(times[i] * 1e3)));
  }
}

absl::Status VelodyneDecoder::Add(absl::string_view bytes, int64_t arrival_ns,
                                  std::vector<RecordedScan>* scans) {
  if (const absl::Status status = velodyne::CheckPacket(bytes); !status.ok()) return status;
  const Packet packet(bytes);
  if (!setup_) {
    if (const absl::Status status = SetUp(packet); !status.ok()) return status;
  }
  const bool dual = setup_->model == Model::kHdl64 ? velodyne::Hdl64IsDual(packet)
                                                   : packet.return_mode() == velodyne::kDualReturn;
  saw_dual_ |= dual;
  Firing firing = {dual, velodyne::BlocksPerFiring(setup_->model, dual),
                   dual ? setup_->dual : setup_->single,
                   clock_.Read(int64_t{packet.microseconds()} * 1000, arrival_ns)};
  if (cutter_.MissesATurn(packet.azimuth(0), firing.time_ns)) Flush(scans);
  double speed = 0;
  for (int block = 0; block < packet.blocks(); ++block) {
    if (block % firing.blocks == 0) {
      firing.time_ns += DarkTimeBefore(packet, block, firing);
      const bool ends = cutter_.EndsBefore(packet.azimuth(block), firing.time_ns, builder_,
                                           kLasersPerBlock * static_cast<size_t>(firing.blocks));
      if (ends) Flush(scans);
      speed = SpeedAt(packet, block, firing);
    }
    AddBlock(packet, block, speed, firing);
  }
  return absl::OkStatus();
}

std::vector<std::string> VelodyneDecoder::Assumptions() const {
  std::vector<std::string> assumptions;
  if (!setup_) return assumptions;
  assumptions.push_back(absl::StrCat("lasers are placed by ", setup_->calibration));
  assumptions.push_back(cutter_.Description());
  assumptions.push_back(clock_.Description());
  if (saw_dual_) assumptions.push_back(kBothReturnsKept);
  return assumptions;
}

}  // namespace

absl::StatusOr<std::unique_ptr<PacketDecoder>> MakeVelodyneDecoder(const PacketOptions& options) {
  std::optional<Model> model;
  if (!options.sensor.empty()) {
    const absl::StatusOr<Model> named = velodyne::ModelOfName(options.sensor);
    if (!named.ok()) return named.status();
    model = *named;
  }
  if (!std::isfinite(options.cut_azimuth_deg) || std::abs(options.cut_azimuth_deg) > 360) {
    return absl::InvalidArgumentError("the azimuth of the cut must be within 360 degrees");
  }
  std::optional<Calibration> calibration;
  if (!options.calibration.empty()) {
    absl::StatusOr<Calibration> parsed = velodyne::ParseCalibration(options.calibration);
    if (!parsed.ok()) return parsed.status();
    calibration = *std::move(parsed);
  }
  if (model) {
    const absl::Status status = velodyne::CheckCalibration(
        *model, calibration ? calibration : velodyne::ManualCalibration(*model));
    if (!status.ok()) return status;
  }
  return std::make_unique<VelodyneDecoder>(options, model, std::move(calibration));
}

}  // namespace isthmus::readers
