#include "client/readers/packets/turn_cutter.h"

#include <absl/strings/str_format.h>

#include <cmath>
#include <cstdlib>

#include "client/readers/packets/laser_geometry.h"
#include "client/readers/packets/limits.h"

namespace isthmus::readers {

TurnCutter::TurnCutter(double cut_deg, bool by_flush)
    : cut_(Turned(static_cast<int>(std::lround(cut_deg * 100)))), by_flush_(by_flush) {}

bool TurnCutter::MissesATurn(int azimuth, int64_t time_ns) {
  const int64_t passed_ns = packet_ns_ ? time_ns - *packet_ns_ : 0;
  const int step = Turned(azimuth - packet_azimuth_);
  packet_ns_ = time_ns;
  packet_azimuth_ = azimuth;
  if (std::abs(passed_ns) <= kPacketGapNs) {
    if (passed_ns > 0 && step > 0 && step < kTurn / 2)
      speed_ = step / static_cast<double>(passed_ns);
    return false;
  }
  if (by_flush_) return false;
  if (passed_ns < 0 || passed_ns > kLongestTurnNs || speed_ == 0) return true;
  return static_cast<double>(passed_ns) * speed_ >= kTurn;
}

bool TurnCutter::EndsBefore(int azimuth, int64_t time_ns, const ScanBuilder& scan, size_t points) {
  azimuth = Turned(azimuth - cut_);
  // The encoder may tremble: what looks like nearly a whole turn is none.
  const int forward = last_azimuth_ ? Turned(azimuth - *last_azimuth_) : 0;
  const bool passed =
      last_azimuth_ && forward < kTurn - kMaxAzimuthStep && *last_azimuth_ + forward >= kTurn;
  last_azimuth_ = azimuth;
  if (scan.size() + points > kMaxTurnPoints) return true;
  const bool too_long = !scan.empty() && time_ns - scan.first_ns() > kLongestTurnNs;
  return (passed || too_long) && !by_flush_;
}

std::string TurnCutter::Description() const {
  if (by_flush_) return "scans are the messages, each a whole turn";
  return absl::StrFormat("scans begin where the sensor's azimuth passes %g degrees", cut_ / 100.0);
}

}  // namespace isthmus::readers
