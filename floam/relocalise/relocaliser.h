// The relocaliser: finds a kidnapped robot anywhere in what its session has seen.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/cloud.h"
#include "core/map/submap.h"
#include "floam/map/map_memory.h"
#include "floam/match/match_quality.h"
#include "floam/match/scan_matcher.h"
#include "floam/relocalise/limits.h"
#include "floam/relocalise/place_check.h"
#include "floam/relocalise/pose_search.h"
#include "floam/scan/scan_frame.h"
#include "floam/scan/scan_image.h"

namespace isthmus::floam {

struct RelocaliserOptions {
  MapMemoryOptions memory;
  PoseSearchOptions search;
  PlaceCheckOptions check;

  // When to look.
  int patience = 5;  // Lost scans before the first search.
  // Lost scans between searches, so many times more from one to the next, from `patience` on.
  double spacing_growth = 4;
  int max_spacing = 60;
  size_t lookups_per_scan = 10'000'000;  // Then the search goes on with the next scan.

  // Options of the search.
  double view_m = kViewM;       // Things farther from the sensor are left out.
  double wall_spacing_m = 0.8;  // Spacing of the scan's walls that are compared.
  int min_walls = 25;           // Walls of the scan; fewer do not tell one place from another.
  double reach_m = 8;           // From where the sensor has been.
  double region_m = 51.2;       // The map is searched in squares of this size.

  // The evidence required to be sure.
  int confirmations = 5;         // Scans in a row at the same place, or moving on from it.
  int max_candidates = 8;        // Places followed at a time.
  int max_followed = 100;        // Scans, after which doubtful places are given up.
  double min_score = 0.65;       // Score of the search, see FoundPose.
  double min_agreement = 0.92;   // Relative to the usual, see MatchQuality; so is
  double min_share = 0.65;       // the share of surfaces that have a plane of the map.
  double least_agreement = 0.8;  // The same, whatever is usual.
  double least_share = 0.45;
  double more_through = 0.12;  // Than usual, of walls: see MatchQuality.
  double max_surprise_m = kForetoldM;
  double max_surprise_rad = kForetoldRad;
};

// The scan is compared with the map from above, at every place and heading there is
// (pose_search.h); the best few are matched in full, and must hold for several scans. A place is
// claimed only if the scan lies on the map about as well as it did while tracking, the map shows no
// walls that the scan looks through, and no other place does nearly as well: of twin rooms neither
// is claimed. A room never seen that is the exact twin of one that was cannot be told from it, by
// this or anything. The robot must be about as level as it was last. Not thread safe; starts no
// threads.
class Relocaliser {
 public:
  // `R_base_sensor` is how the sensor is mounted on the robot: rotation of T_base_sensor.
  Relocaliser(const MatchOptions& matching, const RelocaliserOptions& options,
              const Eigen::Quaterniond& R_base_sensor = Eigen::Quaterniond::Identity());

  // Finished submaps of the session, in any order. Takes a few milliseconds, and memory by the area
  // seen: see MapMemory.
  void Remember(const Submap& submap);
  // Looks in what somebody else remembers from now on, in a frame whose z points up, instead of in
  // its own; Find answers in that frame, turned by the inverse of `R_base_sensor`.
  void UseMemory(std::shared_ptr<const MapMemory> memory);
  const MapMemory& memory() const { return *memory_; }
  // The remembered points within a distance, odom frame.
  Cloud PointsAround(const Eigen::Vector3d& position, double radius_m) const;

  // Finds where a scan was taken that the odometry could not place. To be asked for every lost
  // scan, in order; none while not sure. `last` is the last pose known, for the tilt; `usual` how
  // well scans matched while tracked; `reference_s` the instant of the pose wanted, relative to the
  // scan's END.
  std::optional<MatchResult> Find(const ScanFrame& frame, const Pose& last,
                                  const MatchQuality& usual, double reference_s);

  // The remembered walls as a scan sees them, from anywhere.
  WallsSeen Walls(const ScanFrame& frame, const Pose& T_odom_sensor);

  // The sensor is tracked again: whatever was suspected is forgotten.
  void Reset();

  // For state_codec.h: of the search, not of what is remembered.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.check_, self.lost_, self.next_search_, self.spacing_, self.last_ns_, self.regions_,
       self.sensors_, self.candidates_, self.exhaustive_);
  }
  // Remembers what `other` did, which is not to be used any more.
  void TakeMemory(Relocaliser* other) {
    own_ = std::move(other->own_);
    memory_ = own_;
  }
  // True if the last Find was sure of a place but for another that does nearly as well.
  bool contested() const { return contested_; }
  bool searching() const { return !regions_.empty(); }

 private:
  // A place where the sensor may be.
  struct Candidate {
    MatchResult match;  // Match of the newest scan, in the level frame.
    double score = 0;
    int scans = 0;  // Scans that it was followed.
    int sure = 0;   // The last of these in a row that met the strict standard.
    double agreement = 0, share = 0, through = 0;  // Sums over `scans`.

    // For state_codec.h. Only the pose of the match: the next scan replaces the rest.
    template <typename Self, typename Io>
    static void Fields(Self& self, Io& io) {
      io(self.match.pose, self.score, self.scans, self.sure, self.agreement, self.share,
         self.through);
    }
  };
  struct Region {
    int x = 0, y = 0;
    auto operator<=>(const Region&) const = default;

    // For state_codec.h.
    template <typename Self, typename Io>
    static void Fields(Self& self, Io& io) {
      io(self.x, self.y);
    }
  };

  void BeginSearch();
  void SearchSome(const Eigen::Quaterniond& tilt, double reference_s, const MatchQuality& usual);
  void InspectPlace(const FoundPose& found, const Eigen::Quaterniond& tilt, double reference_s,
                    const MatchQuality& usual);
  void FollowCandidates(const ScanFrame& frame, double reference_s, const MatchQuality& usual);
  void ScoreCandidate(const PlaceMatch& place, const MatchQuality& usual,
                      Candidate* candidate) const;
  bool IsStrict(const PlaceMatch& place, double score, const MatchQuality& usual) const;
  bool IsRival(const Candidate& other, const Candidate& best) const;
  std::optional<MatchResult> DecidePlace();
  void MergeCandidates();
  double HeightAt(const Eigen::Vector2d& position) const;

  const RelocaliserOptions options_;
  const Pose T_level_odom_;  // All is done in a frame with odom's origin and z up.
  std::shared_ptr<MapMemory> own_;
  std::shared_ptr<const MapMemory> memory_;  // The own one, unless another is used.
  PlaceCheck check_;
  ScanImage image_;

  int lost_ = 0;         // Scans in a row.
  int next_search_ = 0;  // The lost scan with which the next search begins.
  int spacing_ = 0;
  int64_t last_ns_ = 0;          // Stamp of the last lost scan.
  std::vector<Region> regions_;  // Still to be searched, the next one last.
  std::vector<Eigen::Vector3d> sensors_;
  std::vector<Candidate> candidates_;
  bool exhaustive_ = true;  // The search so far has left nothing out.
  bool contested_ = false;
};

}  // namespace isthmus::floam
