#include "lab/bench/recordings/nebula_azimuths.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include "client/readers/packets/capture/pcap_file.h"
#include "client/readers/packets/laser_geometry.h"
#include "client/readers/packets/packet_decoder.h"
#include "client/readers/packets/velodyne/velodyne_calibration.h"
#include "core/io/file_io.h"

namespace isthmus::bench {
namespace {

using namespace readers::velodyne;  // NOLINT(google-build-using-namespace)
using readers::Calibration;
using readers::kTurn;
using readers::LaserGeometry;
using readers::capture::PcapFile;

// Azimuths of a packet's blocks, and how far it turns in each, as nebula goes through them.
struct Turning {
  int azimuth[kBlocks];
  float step[kBlocks];
};

Turning TurningOf(const Packet& packet, bool dual) {
  const int ahead = dual ? 2 : 1;
  Turning turning = {};
  int next = packet.azimuth(0);
  float last_step = 0;
  for (int block = 0; block < kBlocks; ++block) {
    turning.azimuth[block] = next;
    if (block < kBlocks - ahead) {
      next = packet.azimuth(block + ahead);
      last_step = static_cast<float>((kTurn + next - turning.azimuth[block]) % kTurn);
      turning.step[block] = last_step;
    } else {
      turning.step[block] = !dual && block == kBlocks - 1 ? 0 : last_step;
    }
  }
  return turning;
}

class NebulaDecoder {
 public:
  NebulaDecoder(Model model, const Calibration& calibration)
      : model_(model), calibration_(calibration), geometry_(calibration) {}

  void Add(const Packet& packet, PointList& list) const {
    const bool dual = packet.return_mode() == kDualReturn;
    const Turning turning = TurningOf(packet, dual);
    for (int block = 0; block < kBlocks; ++block) {
      for (int i = 0; i < kLasersPerBlock; ++i) {
        const uint16_t range = packet.range(block, i);
        const bool same = dual && block % 2 == 1 && packet.range(block - 1, i) == range;
        if (range == 0 || same) continue;
        AddPoint(i, turning.azimuth[block], turning.step[block], range, list);
      }
    }
  }

 private:
  void AddPoint(int i, int azimuth, float step, uint16_t range, PointList& list) const {
    const size_t laser = static_cast<size_t>(i % Lasers(model_));
    const double turned = calibration_.lasers[laser].rotation * 180 / std::numbers::pi * 100;
    const int cycle = i / 16;
    const float part =
        model_ == Model::kVlp32
            ? 2.304F / 55.296F * static_cast<float>(i)
            : (static_cast<float>(i % 16) * 2.304F + static_cast<float>(cycle) * 55.296F) /
                  110.592F;
    const float exact = static_cast<float>(static_cast<float>(azimuth) + step * part - turned);
    const double rounded = std::round(exact);
    const auto at = geometry_.Locate(laser, rounded + turned, range, 0);
    list.x.push_back(at.x);
    list.y.push_back(at.y);
    list.z.push_back(at.z);
    list.rings.push_back(at.ring);
  }

  Model model_;
  Calibration calibration_;
  LaserGeometry geometry_;
};

absl::StatusOr<Calibration> CalibrationOf(Model model, const std::string& path) {
  if (!path.empty()) {
    const absl::StatusOr<std::string> yaml = io::ReadFile(path);
    return yaml.ok() ? ParseCalibration(*yaml) : absl::StatusOr<Calibration>(yaml.status());
  }
  const std::optional<Calibration> manual = ManualCalibration(model);
  if (!manual) return absl::InvalidArgumentError("a calibration must be given");
  return *manual;
}

}  // namespace

absl::StatusOr<PointList> ReadLikeNebula(const std::string& capture,
                                         const std::string& calibration) {
  absl::StatusOr<std::unique_ptr<PcapFile>> file = PcapFile::Open(capture);
  if (!file.ok()) return file.status();
  std::optional<NebulaDecoder> decoder;
  PointList list;
  while (const std::optional<PcapFile::Arrived> arrived = (*file)->Next()) {
    if (!readers::IsVelodynePacket(arrived->datagram.payload)) continue;
    const Packet packet(arrived->datagram.payload);
    if (!decoder) {
      const std::optional<Model> model = ModelOf(packet);
      if (!model || (Lasers(*model) != 16 && *model != Model::kVlp32)) {
        return absl::InvalidArgumentError("only captures of a VLP-16 or VLP-32C can be compared");
      }
      const absl::StatusOr<Calibration> given = CalibrationOf(*model, calibration);
      if (!given.ok()) return given.status();
      if (const absl::Status fits = CheckCalibration(*model, *given); !fits.ok()) return fits;
      decoder.emplace(*model, *given);
    }
    decoder->Add(packet, list);
  }
  return list;
}

}  // namespace isthmus::bench
