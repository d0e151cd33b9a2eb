// The local map of all kinds of features, and when scans go into it.
#pragma once

#include <vector>

#include "core/cloud.h"
#include "floam/map/local_map.h"
#include "floam/match/scan_matcher.h"
#include "floam/odometry_options.h"
#include "floam/scan/features.h"

namespace isthmus::floam {

// Not thread safe.
class FeatureMap {
 public:
  explicit FeatureMap(const OdometryOptions& options);

  // Holds a few scans only: height and tilt may hardly be observed.
  bool IsNew() const { return scans_ < options_.map_first_scans; }
  // Is sparse: most of what a scan sees is not in it yet. So is a map of many scans from one place:
  // far from the sensor there are single rings only.
  bool IsYoung() const { return IsNew() || moved_m_ < options_.map_young_distance_m; }

  // Puts the points where they were measured, the sensor moving as `pose` says.
  void Insert(const Features& features, const ScanPose& pose, double period_s);
  // Inserts what was seen if it is one of the first scans or after enough motion since the last
  // time, and forgets what is out of reach.
  void Update(const Features& features, const ScanPose& pose, double period_s);
  // Goes on with points of an earlier run, the sensor at `T_odom_sensor`. No longer young.
  void Resume(const Cloud& map_odom, const Pose& T_odom_sensor);
  void Clear();

  // The fit of points (sensor frame) to the map's planes: the sum of their weights under the
  // Geman-McClure loss. Level planes do not count: ground is everywhere. Takes about 50 ns per
  // point.
  double ScorePoints(const std::vector<Eigen::Vector3d>& points, const Pose& T_odom_sensor,
                     double kernel_m);

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.surfaces_, self.edges_, self.poles_, self.scans_, self.moved_m_, self.began_odom_,
       self.T_odom_inserted_);
  }

  LocalMap* surfaces() { return &surfaces_; }
  LocalMap* edges() { return &edges_; }
  LocalMap* poles() { return &poles_; }

 private:
  const OdometryOptions options_;
  LocalMap surfaces_, edges_, poles_;
  int scans_ = 0;
  double moved_m_ = 0;                                    // Farthest from where it began.
  Eigen::Vector3d began_odom_ = Eigen::Vector3d::Zero();  // END of the first scan inserted, ...
  Pose T_odom_inserted_;                                  // ... and of the last.
};

}  // namespace isthmus::floam
