// The first two scans: a motion and a map out of nothing.
#pragma once

#include <cstdint>
#include <vector>

#include "floam/match/feature_map.h"
#include "floam/match/scan_to_scan.h"
#include "floam/scan/scan_frame.h"
#include "floam/track/tracker.h"

namespace isthmus::floam {

// The motion within the first scan is only known once the second is matched to it, which depends on
// that motion: taken to be constant over both, it is found by repetition. A map of one scan has few
// planes, and false minima at speed, so matching begins from several motions, from what the two
// scans alone make of these, and at rest; what fits best counts. Not thread safe.
class Start {
 public:
  // Puts the first scan at the origin, as if at rest.
  void TakeFirstScan(const ScanFrame& frame, Tracker* tracker);
  // Matches the second, and makes the map of the first as the motion found says. May be tried again
  // with a later scan if the match does not fit.
  MatchResult TrackSecondScan(const ScanFrame& frame, Tracker* tracker, FeatureMap* map);
  // Begins anew with the scan that did not fit, where it was predicted.
  void BeginAnew(const ScanFrame& frame, Tracker* tracker);

  int attempts() const { return attempts_; }  // Calls of TrackSecondScan since the first scan.

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.first_, self.period_s_, self.stamp_ns_, self.T_odom_first_, self.attempts_);
    if constexpr (Io::kIsReading) io.Expect(self.period_s_ >= 0 && self.period_s_ < 10);
  }

 private:
  void KeepFirstScan(const ScanFrame& frame, const Pose& T_odom_end, Tracker* tracker);
  // Estimates of the motion from the two scans alone, best first.
  std::vector<ScanToScanResult> MotionsBetween(const ScanFrame& frame, double elapsed_s);
  // The second scan's match to the first's map, with that motion (twist) or what was found to be.
  struct Beginning {
    ScanPose first;
    MatchResult second;
    double score = 0;
  };
  Beginning MatchFrom(const ScanToScanResult& moved, const ScanFrame& frame, Tracker* tracker,
                      FeatureMap* map);

  ScanToScan scan_to_scan_;
  Features first_;
  double period_s_ = 0;
  int64_t stamp_ns_ = 0;
  Pose T_odom_first_;  // END of the first scan.
  int attempts_ = 0;
};

}  // namespace isthmus::floam
