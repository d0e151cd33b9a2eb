#include <absl/strings/str_cat.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "client/readers/packets/angle_file.h"
#include "client/readers/packets/hesai/hesai_model.h"
#include "client/readers/packets/hesai/hesai_packet.h"
#include "client/readers/packets/laser_geometry.h"
#include "client/readers/packets/turn_decoder.h"

namespace isthmus::readers {
namespace hesai {
namespace {

absl::StatusOr<Calibration> CalibrationOf(Model model, const std::string& csv) {
  if (!csv.empty()) return ParseAngles(csv, Lasers(model));
  if (std::optional<Calibration> nominal = NominalCalibration(model)) {
    return *std::move(nominal);
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "a ", NameOf(model),
      " needs the angles of its unit: give the CSV of its angle correction (laser, elevation, "
      "azimuth) as the calibration"));
}

class HesaiDecoder : public TurnDecoder {
 public:
  HesaiDecoder(const PacketOptions& options, std::optional<Model> wanted)
      : TurnDecoder(options), wanted_(wanted) {}

  absl::Status Add(absl::string_view bytes, int64_t arrival_ns,
                   std::vector<RecordedScan>* scans) override;
  std::vector<std::string> Assumptions() const override;

 private:
  absl::Status SetUp(const Packet& packet);
  void AddBlock(const Packet& packet, int block, const FiringState& state, int64_t packet_ns);

  const std::optional<Model> wanted_;
  // Known from the first packet on.
  std::optional<Model> model_;
  std::string source_;
  std::optional<LaserGeometry> geometry_;
  bool saw_returns_ = false;
};

absl::Status HesaiDecoder::SetUp(const Packet& packet) {
  if (wanted_ && *wanted_ != packet.model()) {
    return absl::FailedPreconditionError(absl::StrCat("the packets are those of a ",
                                                      NameOf(packet.model()), ", not of the ",
                                                      NameOf(*wanted_), " that was named"));
  }
  absl::StatusOr<Calibration> calibration = CalibrationOf(packet.model(), options_.calibration);
  if (!calibration.ok()) return absl::FailedPreconditionError(calibration.status().message());
  calibration->range_unit_m = packet.range_unit_m();
  model_ = packet.model();
  source_ = calibration->source;
  geometry_.emplace(*calibration);
  return absl::OkStatus();
}

// In the frame of the manuals, which the maker's drivers publish in: y at azimuth 0, x at 90.
void HesaiDecoder::AddBlock(const Packet& packet, int block, const FiringState& state,
                            int64_t packet_ns) {
  const int first = block - block % state.returns;
  for (int laser = 0; laser < packet.lasers(); ++laser) {
    const uint16_t range = packet.range(block, laser);
    bool wanted = range != 0;
    for (int other = first; other < block; ++other) {
      wanted = wanted && packet.range(other, laser) != range;
    }
    if (!wanted) continue;
    const LaserGeometry::Position at =
        geometry_->Locate(static_cast<size_t>(laser), packet.azimuth(block), range,
                          packet.reflectivity(block, laser));
    builder_.Add({-at.y, at.x, at.z, at.intensity, at.ring},
                 packet_ns + FiringTimeNs(*model_, state, block, laser));
  }
}

absl::Status HesaiDecoder::Add(absl::string_view bytes, int64_t arrival_ns,
                               std::vector<RecordedScan>* scans) {
  const absl::StatusOr<Packet> packet = Packet::Parse(bytes);
  if (!packet.ok()) return packet.status();
  if (!geometry_) {
    if (const absl::Status status = SetUp(*packet); !status.ok()) return status;
  }
  if (packet->model() != *model_) {
    return absl::InvalidArgumentError(absl::StrCat("a packet of a ", NameOf(packet->model()),
                                                   " comes among those of a ", NameOf(*model_)));
  }
  const int64_t packet_ns = clock_.Read(packet->time_ns(), arrival_ns);
  if (cutter_.MissesATurn(packet->azimuth(0), packet_ns)) Flush(scans);
  for (int block = 0; block < packet->blocks(); ++block) {
    const FiringState state = packet->StateOf(block);
    const size_t points =
        static_cast<size_t>(packet->lasers()) * static_cast<size_t>(state.returns);
    if (block % state.returns == 0 &&
        cutter_.EndsBefore(packet->azimuth(block), packet_ns, builder_, points)) {
      Flush(scans);
    }
    saw_returns_ |= state.returns > 1;
    AddBlock(*packet, block, state, packet_ns);
  }
  return absl::OkStatus();
}

std::vector<std::string> HesaiDecoder::Assumptions() const {
  std::vector<std::string> assumptions;
  if (!geometry_) return assumptions;
  assumptions.push_back(absl::StrCat("lasers of the ", NameOf(*model_), " are placed by ", source_,
                                     ", in the frame of its manual: y at azimuth 0"));
  assumptions.push_back(cutter_.Description());
  assumptions.push_back(clock_.Description());
  if (saw_returns_) assumptions.push_back(kBothReturnsKept);
  return assumptions;
}

}  // namespace
}  // namespace hesai

absl::StatusOr<std::unique_ptr<PacketDecoder>> MakeHesaiDecoder(const PacketOptions& options) {
  std::optional<hesai::Model> model;
  if (!options.sensor.empty()) {
    const absl::StatusOr<hesai::Model> named = hesai::ModelOfName(options.sensor);
    if (!named.ok()) return named.status();
    model = *named;
    const absl::StatusOr<Calibration> calibration =
        hesai::CalibrationOf(*model, options.calibration);
    if (!calibration.ok()) return calibration.status();
  }
  return std::make_unique<hesai::HesaiDecoder>(options, model);
}

}  // namespace isthmus::readers
