// Motion of the sensor from one scan to the next, by these two scans alone.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/pose.h"
#include "floam/match/limits.h"
#include "floam/match/ring_index.h"
#include "floam/match/scan_matcher.h"
#include "floam/scan/features.h"
#include "floam/scan/limits.h"
#include "floam/scan/undistort.h"

namespace isthmus::floam {

// The public A-LOAM's, where it has a name for them.
struct ScanToScanOptions {
  int rounds = 2;       // Times that neighbours are looked for ...
  int iterations = 4;   // ... and Gauss-Newton steps with each set of them.
  float base_m = 1;     // A ring's direction is that between points so far to either side.
  float flat_m = 0.1F;  // The neighbours of both lie this near to a plane through them.
  float reach_m = 5;    // Neighbours farther away than this are none.
  int ring_reach = kNeighbourRings;
  double kernel_m = 0.1;      // Scale of the Huber loss.
  double row_sigma_m = 0.3;   // Error of a match: planes lie between rings far apart.
  double pole_sigma_m = 0.1;  // The same for poles.
  float pole_reach_m = 0.8F;
  double point_noise_m = 0.04;  // Noise of the points that planes and lines are put through.
  // The spread of the motion about the guess, where nothing else is known of it: what is not
  // observed stays.
  double guess_sigma_m = 1.2, guess_sigma_rad = 0.6;
  // Less than this many matches, or a motion this far from what it was guessed to be: see Guess.
  int min_used = kMinMatches;
  double max_surprise_m = 0.6;
  double max_surprise_rad = 0.3;
};

struct ScanToScanResult {
  Vector6d twist = Vector6d::Zero();  // Per second, sensor frame; constant over both scans.
  int features = 0;                   // Tried.
  int used = 0;                       // With a line or plane.
  double score = 0;                   // Sum of the weights of these in a robust loss.
  // The same without level planes, for ground is everywhere, and with poles, which are hardly met
  // by chance, counting for more: of several motions the one with the most is right.
  double evidence = 0;
  // The uncertainty of the motion d that follows that of the twist: after matching, and by the
  // matches alone.
  Matrix6d covariance = Matrix6d::Zero(), information = Matrix6d::Zero();
};

// The odometry stage of LOAM: J. Zhang, S. Singh, "LOAM: Lidar Odometry and Mapping in Real-time",
// RSS 2014, section V, as in the public A-LOAM. Every edge point of a scan is matched to the line
// through its nearest edge point of the previous scan and the nearest to that place on a
// neighbouring ring, every surface point to the plane through the nearest point, along the
// direction of its ring there, and the nearest on a neighbouring ring. Poles, which LOAM does not
// have, are matched to the nearest pole.
//
// LOAM takes the previous scan to its END by the motion found for it. That feeds an error back:
// what two scans tell is the motion from the middle of one to the middle of the other, so a motion
// taken too large for the first comes out too small for the second by as much, and so on, growing
// where little is observed. Here both scans stay as measured, and a point moves by the motion in
// the time between it and the one it is matched to: about one turn. Not thread safe: holds scratch
// memory.
class ScanToScan {
 public:
  explicit ScanToScan(const ScanToScanOptions& options = {});

  // The scan that the next one is matched to.
  void SetPrevious(const Features& features);

  // Minimises from `guess`, a twist per second, for a scan whose END is `elapsed_s` > 0 after that
  // of the previous, together with what is known of the motion: it is that of the guess and then d,
  // of covariance `prior`. Never fails: see ScanToScanResult::used.
  ScanToScanResult Match(const Features& features, const Vector6d& guess, double elapsed_s,
                         const Matrix6d& prior);
  // The same, of the motion nothing known but that it is near the guess, and points taken to be
  // without noise, as in A-LOAM.
  ScanToScanResult Match(const Features& features, const Vector6d& guess, double elapsed_s);

  // ScanToScanResult::evidence for a motion as it is.
  double Evidence(const Features& features, const Vector6d& twist, double elapsed_s);

  // A guess for scan-to-map matching: `prediction` (at the END of the scan, `elapsed_s` after that
  // of the previous), corrected by Match; unchanged where that has nothing credible to say.
  ScanPose Guess(const Features& features, const ScanPose& prediction, double elapsed_s);

  // For state_codec.h.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.edge_points_, self.surface_points_, self.poles_);
    if constexpr (Io::kIsReading) self.is_indexed_ = false;
  }

 private:
  // A point and the plane it should lie on, n . q = offset, in the sensor frame at the time of the
  // point of the previous scan that it was matched to.
  struct Row {
    Eigen::Vector3f position;  // As measured.
    float since;               // Seconds since that point.
    float weight;
    Eigen::Vector3f normal;
    float offset;
    Eigen::Vector3f on_plane;
    float tilt_variance;  // The normal's, by the noise of the points it rests on.
  };
  void Index();  // Unless it is: most scans are only kept.
  ScanToScanResult Minimise(const Features& features, const Vector6d& guess, double elapsed_s,
                            const Matrix6d& prior, double point_noise_m);
  // Rows of one residual (surfaces) and of two (edges, poles), the distances to two planes through
  // a line. `noise2`: variance of points.
  void FindPlanes(const Features& features, const ScanMotion& motion, double elapsed_s,
                  float noise2);
  void FindLines(const Features& features, const ScanMotion& motion, double elapsed_s,
                 float noise2);
  void FindPoles(const std::vector<TimedPoint>& poles, const ScanMotion& motion, double elapsed_s);
  // One Gauss-Newton step of the motion in `elapsed_s`; false if there is none to take.
  bool Step(const ScanMotion& motion, double elapsed_s, const PosePrior& prior, Pose* moved,
            ScanToScanResult* result);

  const ScanToScanOptions options_;
  std::vector<TimedPoint> edge_points_, surface_points_, poles_;  // The previous scan's, ...
  RingIndex edges_, surfaces_;                                    // ... and an index of these.
  bool is_indexed_ = false;
  std::vector<Row> surface_rows_, edge_rows_, pole_rows_;
  std::vector<MatchRow> rows_;
};

}  // namespace isthmus::floam
