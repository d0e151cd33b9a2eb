// The evidence of anchors about how two maps lie: beside what the maps show.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/map/anchor.h"
#include "core/pose.h"
#include "server/matching/prepared/map_poses.h"
#include "server/matching/prepared/prepared_map.h"

namespace isthmus::matching {

// The anchors of two maps' submaps. Immutable, thread safe.
class AnchorPrior {
 public:
  AnchorPrior() = default;
  // In order of their submaps; those that neither map has are left out.
  AnchorPrior(const PreparedMap& a, const PreparedMap& b, const std::vector<Anchor>& anchors);

  // Nothing is known that holds for both maps.
  bool empty() const { return of_a_.empty() || of_b_.empty(); }

  // The logarithm of how much likelier the anchors are if the maps lie so than if either lay
  // anywhere on the site, whichever way round (the ratio of evidences, with places and headings
  // integrated out). 0 where nothing is known. `poses`: in a's odom frame, those of b moved by
  // `T_a_a` in it.
  double LogOdds(const MapPoses& poses, const Pose& T_a_a = Pose()) const;

  // T_a_b between the odom frames, where the anchors of each map say where it is and which way
  // round. Where heights are not known, that of the sensors where the maps come nearest.
  std::optional<Pose> Guess() const;
  // Standard deviation of the guess, metres.
  double guess_sigma_m() const { return guess_sigma_m_; }

 private:
  // An anchored submap, as the site has it. Weights are 1 / variance; 0 is not known.
  struct Tie {
    size_t submap;  // Position in its map.
    Eigen::Vector3d T_site;
    double heading;  // Radians.
    double xy, z, turn;
  };
  // A tie with its submap in some level frame.
  struct Placed {
    const Tie* tie;
    Pose T_level_submap;
  };
  // The evidence of a set of ties on T_site_level.
  struct Fit;

  static void Place(const std::vector<Tie>& ties, const Pose& T_level_map,
                    const std::vector<Pose>& poses, std::vector<Placed>* placed);
  static Fit FitTo(const std::vector<Placed>& placed);

  std::vector<Tie> of_a_, of_b_;
  Pose T_level_a_, T_level_b_;
  MapPoses in_odom_;  // All submaps, each map in its own odom frame.
  double alone_ = 0;  // Log evidences of either map's own ties.
  double guess_sigma_m_ = 0;
};

}  // namespace isthmus::matching
