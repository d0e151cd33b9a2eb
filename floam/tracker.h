// Follows the sensor from scan to scan.
#pragma once

#include <cstdint>
#include <optional>

#include "floam/feature_map.h"
#include "floam/match_quality.h"
#include "floam/odometry_options.h"
#include "floam/scan_frame.h"
#include "floam/scan_matcher.h"

namespace isthmus::floam {

// Pose extrapolated by the twist, at most a few seconds: what is said while nothing is seen.
// `reference_s` is that of the result, relative to the END of the new scan.
ScanPose Predict(const ScanPose& last, double elapsed_s, double reference_s);

// Where the sensor was last, how it moved, and how a new scan is matched from there. Not thread
// safe.
class Tracker {
 public:
  Tracker(const SensorModel& sensor, const OdometryOptions& options);

  // The last scan that was matched. Its reference is the middle of the scan in kContinuous, else
  // the END.
  const ScanPose& last() const { return last_; }
  double ElapsedSeconds(const ScanFrame& frame) const;
  // The instant within the scan whose pose is estimated, relative to its END.
  double ReferenceTime(const ScanFrame& frame) const;
  // Whether too much may have happened since `last` to trust in the motion going on.
  bool IsAfterGap(const ScanFrame& frame) const;

  ScanPose Prediction(const ScanFrame& frame) const;

  // Matches from `guess`, with what the motion so far tells about the motion within the scan.
  MatchResult Match(const ScanFrame& frame, const ScanPose& guess, const MatchOptions& options,
                    FeatureMap* map);
  // What to match with: the options' settings and, while the map is young, a hold on height and
  // tilt.
  MatchOptions Matching(const FeatureMap& map) const;

  // Whether the scan lies on the map well enough to be believed, wherever that is, ...
  bool Fits(const MatchResult& match, const FeatureMap& map) const;
  // ... and whether that is near the prediction.
  bool IsExpected(const MatchResult& match, const ScanPose& prediction) const;

  // Takes the match for the truth; it goes on from there.
  void Adopt(const ScanFrame& frame, MatchResult* match);
  void Begin(const ScanPose& pose, int64_t stamp_ns);

  ScanMatcher* matcher() { return &matcher_; }

 private:
  bool IsContinuous() const { return options_.mode == OdometryMode::kContinuous; }
  std::optional<TwistPrior> Prior(const ScanFrame& frame, const ScanPose& guess) const;

  const SensorModel sensor_;
  const OdometryOptions options_;
  ScanMatcher matcher_;
  ScanPose last_;
  int64_t last_ns_ = 0;
};

}  // namespace isthmus::floam
