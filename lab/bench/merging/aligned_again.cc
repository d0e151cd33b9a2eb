#include "lab/bench/merging/aligned_again.h"

#include <optional>

#include "server/matching/pairs/submap_alignment.h"
#include "server/matching/prepared/prepared_map.h"
#include "server/pose_graph/information.h"
#include "server/pose_graph/optimize.h"

namespace isthmus::bench {
namespace {

// Share of both radii that middles are apart at most: as of submaps that are looked at for loops.
constexpr double kMostApart = 0.35;
// Metres that submaps may be off where they are aligned, first and then.
constexpr double kGatesM[] = {0.5, 0.25};

std::vector<pose_graph::Edge> OdometryOf(const std::vector<MappedSubmap>& submaps) {
  std::vector<pose_graph::Edge> edges;
  for (size_t i = 1; i < submaps.size(); ++i) {
    if (submaps[i].robot != submaps[i - 1].robot) continue;
    const Pose T =
        submaps[i - 1].submap->T_odom_submap.Inverse() * submaps[i].submap->T_odom_submap;
    edges.push_back({static_cast<int>(i) - 1, static_cast<int>(i), T,
                     pose_graph::OdometryInformation(T), false});
  }
  return edges;
}

void AddAlignments(const matching::PreparedSubmaps& prepared, double gate_m,
                   pose_graph::Problem* problem) {
  const std::vector<Pose>& poses = problem->poses;
  for (size_t i = 0; i < prepared.size(); ++i) {
    for (size_t j = i + 1; j < prepared.size(); ++j) {
      const double apart =
          (poses[i] * prepared[i]->center() - poses[j] * prepared[j]->center()).norm();
      if (apart > kMostApart * (prepared[i]->radius_m() + prepared[j]->radius_m())) continue;
      const auto found =
          matching::AlignSubmaps(*prepared[i], *prepared[j], poses[i].Inverse() * poses[j], gate_m);
      if (!found) continue;
      problem->edges.push_back(
          {static_cast<int>(i), static_cast<int>(j), found->T_a_b, found->information, true});
    }
  }
}

}  // namespace

std::vector<Pose> AlignAgain(const std::vector<MappedSubmap>& submaps,
                             const std::vector<Pose>& T_map_submap) {
  matching::PreparedSubmaps prepared;
  for (const MappedSubmap& mapped : submaps) {
    prepared.push_back(matching::PrepareSubmap(mapped.submap));
  }
  pose_graph::Problem problem;
  problem.poses = T_map_submap;
  problem.fixed = {0};
  for (const double gate_m : kGatesM) {
    problem.edges = OdometryOf(submaps);
    AddAlignments(prepared, gate_m, &problem);
    const auto solved = pose_graph::Optimize(problem);
    if (!solved.ok()) return T_map_submap;
    problem.poses = solved->poses;
  }
  return problem.poses;
}

}  // namespace isthmus::bench
