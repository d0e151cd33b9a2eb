// The tracker, which follows the sensor from scan to scan.
#pragma once

#include <cstdint>
#include <optional>

#include "floam/match/feature_map.h"
#include "floam/match/motion_model.h"
#include "floam/match/scan_matcher.h"
#include "floam/match/scan_to_scan.h"
#include "floam/odometry_options.h"
#include "floam/scan/scan_frame.h"

namespace isthmus::floam {

// Pose extrapolated by the twist, at most a few seconds: what is said while nothing is seen.
// `reference_s` is that of the result, relative to the END of the new scan.
ScanPose Predict(const ScanPose& last, double elapsed_s, double reference_s);

// A place about which little is known.
PosePrior Near(const Pose& T_odom_sensor);

// A scan that was matched: where the sensor was and how it moved, and when.
struct Sighting {
  ScanPose pose;  // Its reference is the middle of the scan in kContinuous, else the END.
  int64_t stamp_ns = 0;

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.pose, self.stamp_ns);
  }
};

// Adds what the scan before says of the motion to what the map says. Once the map is more than
// these few scans that does not make up for what it does not tell: steps add up, errors as well.
void JoinMotion(const ScanToScanResult& moved, const OdometryOptions& options,
                const FeatureMap& map, MatchResult* match);

// Matches scans from where the sensor was seen last. Not thread safe.
class Tracker {
 public:
  Tracker(const SensorModel& sensor, const OdometryOptions& options);

  const OdometryOptions& options() const { return options_; }
  const Sighting& last() const { return last_; }
  // Goes on from there, of the motion only its twist known.
  void BeginAt(const Sighting& sighting);
  // Takes the match to the map for the truth, or if `doubtful` for the best there is; it goes on
  // from there.
  void AdoptMatch(const ScanFrame& frame, const FeatureMap& map, bool doubtful, MatchResult* match);

  // The instant within the scan whose pose is estimated, relative to its END.
  double ReferenceTime(const ScanFrame& frame) const;
  // From the END of the scan seen last to that of the new one.
  double ElapsedSeconds(const ScanFrame& frame) const;
  // Between the instants whose poses are estimated.
  double SecondsBetween(const ScanFrame& frame) const;
  // True if too much may have happened in between to trust in the motion going on.
  bool IsAfterGap(const ScanFrame& frame) const;
  // The same for the scan seen last: key scans.
  bool WasAfterGap() const { return was_after_gap_; }
  // The pose of the scan if the motion goes on.
  ScanPose Prediction(const ScanFrame& frame) const;

  // Matches from `guess`, with what the motion so far tells about where the scan should be and
  // about the motion within it, and while the map is thin with what the scan before tells.
  MatchResult Match(const ScanFrame& frame, const ScanPose& guess, FeatureMap* map);
  // The same with what the scan before tells, however much the map does.
  MatchResult MatchToLast(const ScanFrame& frame, const ScanPose& guess, FeatureMap* map);
  // The same from a place that may be anywhere near, whatever the motion so far.
  MatchResult MatchNear(const ScanFrame& frame, const ScanPose& guess, const MatchOptions& options,
                        FeatureMap* map);
  // The pose of the scan if the motion along directions that are no longer observed goes on as it
  // was on average: the last scans before had little to say of it, and their noise would be kept
  // from then on.
  ScanPose SteadyPrediction(const ScanFrame& frame, const Degeneracy& unobserved) const;
  bool IsDegenerate() const { return degenerate_; }  // The last match was.
  // True if one was, less than a second before this scan: of the speed along what was not observed
  // no more is known than how steadily the robot drove.
  bool IsSteady(const ScanFrame& frame) const;

  // True if the scan lies on the map well enough to be believed at all, ...
  bool Fits(const MatchResult& match, const FeatureMap& map) const;
  // ... and whether that is near the prediction, or no farther from it than the motion so far lets
  // expect.
  bool IsExpected(const ScanFrame& frame, const MatchResult& match,
                  const ScanPose& prediction) const;

  ScanMatcher* matcher() { return &matcher_; }

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.last_, self.motion_, self.degenerate_, self.was_after_gap_, self.acceleration_,
       self.steady_until_ns_, self.steady_, self.shared_twist_, self.scan_to_scan_,
       self.keeps_last_, self.needs_last_);
    if constexpr (Io::kIsReading) io.Expect(self.acceleration_ >= 0 && self.acceleration_ < 1e9);
  }

 private:
  MatchResult Match(const ScanFrame& frame, const ScanPose& guess, bool to_last, FeatureMap* map);
  // The sensor's motion since the scan before, and a prior for the pose then; none if these two
  // scans do not tell.
  std::optional<ScanToScanResult> LookBack(const ScanFrame& frame, PosePrior* prior);
  bool IsContinuous() const { return options_.mode == OdometryMode::kContinuous; }
  std::optional<TwistPrior> Prior(const ScanFrame& frame) const;

  const SensorModel sensor_;
  const OdometryOptions options_;
  ScanMatcher matcher_;
  ScanToScan scan_to_scan_;
  bool keeps_last_ = false;  // In scan_to_scan_.
  bool needs_last_ = false;  // The map is too thin to do without.
  Sighting last_;
  MotionModel motion_;
  bool degenerate_ = false;
  bool was_after_gap_ = false;
  double acceleration_ = 1;      // Fading density of its noise where that was observed, m^2/s^3.
  int64_t steady_until_ns_ = 0;  // Stamp; soon after such a match.
  Vector6d steady_ = Vector6d::Zero();  // Fading average of twists that were observed.
  // Fading average of how much faster scans moved in themselves than from one to the next.
  Vector6d shared_twist_ = Vector6d::Zero();
};

}  // namespace isthmus::floam
