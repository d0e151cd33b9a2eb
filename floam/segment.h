// One odom frame of a robot: from where it began to where the robot was lost for good, if it was.
#pragma once

#include <cstdint>
#include <optional>

#include "core/cloud.h"
#include "core/map/submap.h"
#include "core/map/trajectory.h"
#include "floam/match/feature_map.h"
#include "floam/match/match_quality.h"
#include "floam/match/scan_to_scan.h"
#include "floam/match/unobserved_motion.h"
#include "floam/odometry.h"
#include "floam/odometry_options.h"
#include "floam/relocalise/relocaliser.h"
#include "floam/scan/scan_frame.h"
#include "floam/track/recovery.h"
#include "floam/track/start.h"
#include "floam/track/tracker.h"

namespace isthmus::floam {

// Follows the sensor from scan to scan in one frame and, when it loses it, looks for it there. Not
// thread safe.
class Segment {
 public:
  Segment(const SensorModel& sensor, const OdometryOptions& options);

  // InvalidArgument for a scan that shows too little to begin with.
  absl::Status CheckFirst(const ScanFrame& frame) const;
  // The pose of a scan; to be called for every scan, in order. Sets the result's status,
  // covariances and degeneracy.
  ScanPose Locate(const ScanFrame& frame, OdometryResult* result);
  // Puts what was seen into the map, if the scan located last was matched well enough for that.
  void UpdateMap(const ScanFrame& frame);

  // See Odometry.
  void Resume(const Cloud& map_odom, const Trajectory& recent);
  void Remember(const Submap& submap) { relocaliser_.Remember(submap); }
  // Remembers what `other` did, which is not to be used any more.
  void TakeMemory(Segment* other) { relocaliser_.TakeMemory(&other->relocaliser_); }

  bool HasBegun() const { return phase_ != Phase::kFirst; }
  int64_t previous_ns() const { return previous_ns_; }  // Stamp of the last scan located.
  // For how long scans that show enough could not be matched, up to the last; 0 if that was.
  double SearchedSeconds() const { return lost_ ? searched_s_ : 0; }
  // The time over which scans were matched, without lost ones in between.
  double TrackedSeconds() const { return tracked_s_; }

  const MatchQuality& quality() const { return quality_; }

  // For state_codec.h. `start_` is not asked any more once under way.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.phase_, self.previous_ns_, self.lost_, self.searched_s_, self.tracked_s_,
       self.in_doubt_, self.next_look_s_, self.tracker_, self.map_, self.scan_to_scan_,
       self.quality_, self.unobserved_, self.recovery_, self.relocaliser_);
    if constexpr (Io::kIsReading) io.Expect(self.phase_ <= Phase::kUnderWay);
    if (self.phase_ == Phase::kSecond) io(self.start_);
  }

 private:
  enum class Phase : uint8_t { kFirst, kSecond, kUnderWay };

  // Each of these returns a match to be believed, or none.
  std::optional<MatchResult> TrackSecondScan(const ScanFrame& frame);
  std::optional<MatchResult> TrackScan(const ScanFrame& frame, const ScanPose& prediction);
  std::optional<MatchResult> Relocalise(const ScanFrame& frame);

  // The best match from where the motion leads to.
  MatchResult MatchScan(const ScanFrame& frame, const ScanPose& prediction);
  // True if what is remembered of the surroundings speaks against a match to the local map.
  bool IsContradicted(const ScanFrame& frame, const MatchResult& match);
  // Learns now and then what walls usually look like.
  void LookAtWalls(const ScanFrame& frame, const MatchResult& match);

  ScanPose Prediction(const ScanFrame& frame);
  ScanPose Extrapolate(const ScanPose& prediction, const ScanFrame& frame, OdometryResult* result);
  void AssessMatch(const MatchResult& match, bool relocalised, double elapsed_s,
                   OdometryResult* result);

  const OdometryOptions options_;
  Tracker tracker_;
  FeatureMap map_;
  ScanToScan scan_to_scan_;  // kAloam.
  Start start_;
  MatchQuality quality_;
  UnobservedMotion unobserved_;
  Recovery recovery_;
  Relocaliser relocaliser_;

  Phase phase_ = Phase::kFirst;
  int64_t previous_ns_ = 0;  // Stamp of the last scan, matched or not.
  bool lost_ = false;        // The last scan was.
  double searched_s_ = 0;    // Since then, with something in view.
  double tracked_s_ = 0;
  int in_doubt_ = 0;        // Scans in a row that were followed, but matched unusually badly.
  double next_look_s_ = 0;  // The value of tracked_s_ at the next look at the walls.
};

}  // namespace isthmus::floam
