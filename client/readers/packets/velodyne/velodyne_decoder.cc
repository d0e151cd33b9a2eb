#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include "client/readers/packets/limits.h"
#include "client/readers/packets/packet_decoder.h"
#include "client/readers/packets/scan_builder.h"
#include "client/readers/packets/sensor_clock.h"
#include "client/readers/packets/velodyne/laser_geometry.h"
#include "client/readers/packets/velodyne/velodyne_calibration.h"
#include "client/readers/packets/velodyne/velodyne_model.h"
#include "client/readers/packets/velodyne/velodyne_packet.h"

namespace isthmus::readers {
namespace {

using velodyne::Calibration;
using velodyne::kBlocks;
using velodyne::kLasersPerBlock;
using velodyne::kTurn;
using velodyne::Model;
using velodyne::Packet;

constexpr int64_t kHourNs = 3'600'000'000'000;  // Format

int Turned(int azimuth) { return (azimuth % kTurn + kTurn) % kTurn; }

class VelodyneDecoder : public PacketDecoder {
 public:
  VelodyneDecoder(const VelodyneOptions& options, std::optional<Model> model,
                  std::optional<Calibration> given)
      : options_(options),
        cut_(Turned(static_cast<int>(std::lround(options.cut_azimuth_deg * 100)))),
        wanted_(model),
        given_(std::move(given)),
        clock_(kHourNs, options.utc_offset_ns) {}

  absl::Status Add(absl::string_view bytes, int64_t arrival_ns,
                   std::vector<RecordedScan>* scans) override;
  void Flush(std::vector<RecordedScan>* scans) override {
    if (!builder_.empty()) scans->push_back(builder_.Finish(clock_.offset_ns()));
    last_azimuth_.reset();
  }

  std::string sensor() const override {
    if (setup_) return velodyne::SensorName(setup_->model);
    return wanted_ ? velodyne::SensorName(*wanted_) : "";
  }
  std::vector<std::string> Assumptions() const override;

 private:
  // What is known once the model is.
  struct Setup {
    Model model;
    std::string calibration;
    velodyne::LaserGeometry geometry;
    velodyne::FiringTimes single, dual;
  };

  absl::Status SetUp(const Packet& packet);
  void CutBefore(const Packet& packet, int block, int64_t time_ns,
                 std::vector<RecordedScan>* scans);
  // How a packet was fired.
  struct Firing {
    bool dual;
    int blocks;  // Of each firing.
    const velodyne::FiringTimes& times;
    int64_t time_ns;
  };
  // Whether so much time passed since the last packet that a whole turn may be lost.
  bool MissesATurn(int64_t time_ns) const;
  double SpeedAt(const Packet& packet, int block, const Firing& firing);
  // How long lasers were dark before a block: a sensor with a limited field of view fills a packet
  // with what it sees before and behind the rest of the turn. Nanoseconds.
  int64_t DarkTimeBefore(const Packet& packet, int block, const Firing& firing) const;
  void AddBlock(const Packet& packet, int block, double speed, const Firing& firing);

  const VelodyneOptions options_;
  const int cut_;
  const std::optional<Model> wanted_;
  const std::optional<Calibration> given_;
  std::optional<Setup> setup_;
  SensorClock clock_;
  ScanBuilder builder_;
  std::optional<int64_t> last_time_ns_;  // Of the last packet.
  std::optional<int> last_azimuth_;      // Past the cut.
  double last_speed_ = 0;                // Hundredths of a degree per microsecond.
  bool saw_dual_ = false;
};

absl::Status VelodyneDecoder::SetUp(const Packet& packet) {
  const std::optional<Model> model = wanted_ ? wanted_ : velodyne::ModelOf(packet);
  if (!model) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "packets of Velodyne's product 0x%02x are not known: name the sensor (vlp16, vlp32, hdl32 "
        "or hdl64) if it sends like one of these",
        packet.product()));
  }
  const std::optional<Calibration> calibration =
      given_ ? given_ : velodyne::ManualCalibration(*model);
  if (const absl::Status status = velodyne::CheckCalibration(*model, calibration); !status.ok()) {
    return absl::FailedPreconditionError(status.message());
  }
  setup_.emplace(Setup{*model, calibration->source, velodyne::LaserGeometry(*calibration),
                       velodyne::TimesOf(*model, false), velodyne::TimesOf(*model, true)});
  return absl::OkStatus();
}

void VelodyneDecoder::CutBefore(const Packet& packet, int block, int64_t time_ns,
                                std::vector<RecordedScan>* scans) {
  const int azimuth = Turned(packet.azimuth(block) - cut_);
  // The encoder may tremble: what looks like nearly a whole turn is none.
  const int forward = last_azimuth_ ? Turned(azimuth - *last_azimuth_) : 0;
  const bool passed =
      last_azimuth_ && forward < kTurn - kMaxAzimuthStep && *last_azimuth_ + forward >= kTurn;
  const bool too_long = !builder_.empty() && time_ns - builder_.first_ns() > kLongestTurnNs;
  const bool too_large = builder_.size() + kLasersPerBlock > kMaxTurnPoints;
  if (too_large || ((passed || too_long) && !options_.by_flush)) Flush(scans);
  last_azimuth_ = azimuth;
}

bool VelodyneDecoder::MissesATurn(int64_t time_ns) const {
  if (!last_time_ns_) return false;
  const int64_t passed_ns = time_ns - *last_time_ns_;
  if (std::abs(passed_ns) <= kPacketGapNs) return false;
  if (passed_ns < 0 || passed_ns > kLongestTurnNs || last_speed_ == 0) return true;
  return static_cast<double>(passed_ns) * 1e-3 * last_speed_ >= kTurn;
}

double VelodyneDecoder::SpeedAt(const Packet& packet, int block, const Firing& firing) {
  // The next packet may be lost: the last firing turns as fast as the one before it.
  const int next = block + firing.blocks;
  if (next < kBlocks) {
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
  const int first = packet.flag(block) == velodyne::kLower ? kLasersPerBlock : 0;
  const int lasers = velodyne::Lasers(setup_->model);
  const int banks = setup_->model == Model::kHdl64 ? 2 : 1;
  const bool second = firing.dual && block / banks % 2 == 1;
  for (int i = 0; i < kLasersPerBlock; ++i) {
    const uint16_t range = packet.range(block, i);
    if (range == 0) continue;
    if (second && range == packet.range(block - banks, i)) continue;
    const double behind_us = times[i] - times[0];
    const velodyne::LaserGeometry::Position at =
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
  if (MissesATurn(firing.time_ns) && !options_.by_flush) Flush(scans);
  last_time_ns_ = firing.time_ns;
  double speed = 0;
  for (int block = 0; block < kBlocks; ++block) {
    if (block % firing.blocks == 0) {
      firing.time_ns += DarkTimeBefore(packet, block, firing);
      CutBefore(packet, block, firing.time_ns, scans);
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
  assumptions.push_back(
      options_.by_flush
          ? std::string("scans are the messages, each a whole turn")
          : absl::StrFormat("scans begin where the sensor's azimuth passes %g degrees",
                            cut_ / 100.0));
  assumptions.push_back(clock_.Description());
  if (saw_dual_) {
    assumptions.push_back(
        "of two returns both are points, those of the first block of a firing before those of the "
        "second, and one where they are the same");
  }
  return assumptions;
}

}  // namespace

absl::StatusOr<std::unique_ptr<PacketDecoder>> MakeVelodyneDecoder(const VelodyneOptions& options) {
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
