// A decoder of a sensor that spins: its clock, the scan in the making and the cut of turns.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/readers/packets/packet_decoder.h"
#include "client/readers/packets/scan_builder.h"
#include "client/readers/packets/sensor_clock.h"
#include "client/readers/packets/turn_cutter.h"

namespace isthmus::readers {

// The part that the decoders of all makers share. Not thread safe.
class TurnDecoder : public PacketDecoder {
 public:
  void Flush(std::vector<RecordedScan>* scans) override {
    if (!builder_.empty()) scans->push_back(builder_.Finish(clock_.offset_ns()));
    cutter_.Forget();
  }
  std::string sensor() const override { return "spinning"; }

 protected:
  // `clock_period_ns` is that of SensorClock.
  explicit TurnDecoder(PacketOptions options, int64_t clock_period_ns = 0,
                       std::optional<int64_t> utc_offset_ns = std::nullopt)
      : options_(std::move(options)),
        clock_(clock_period_ns, utc_offset_ns),
        cutter_(options_.cut_azimuth_deg, options_.by_flush) {}

  const PacketOptions options_;
  SensorClock clock_;
  TurnCutter cutter_;
  ScanBuilder builder_;
};

}  // namespace isthmus::readers
