#include "lab/bench/merging/hypothesis_table.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "lab/bench/merging/judge.h"
#include "lab/bench/merging/seen_surface.h"
#include "lab/bench/merging/trial.h"
#include "server/matching/pairs/candidate_search.h"

namespace isthmus::bench {
namespace {

using matching::Hypothesis;

constexpr double kRigidM = 1, kRigidDeg = 3, kJointM = 0.3, kJointDeg = 1;

SessionMap MapOf(const DrivenRobot& robot) {
  SessionMap map;
  map.session = robot.session.id;
  map.submaps = robot.submaps;
  return map;
}

// All that is found, search by search.
std::vector<Hypothesis> Propose(matching::CandidateSearch* search) {
  std::vector<Hypothesis> all;
  std::vector<StageTime> stages;
  const auto add = [&](auto propose) {
    std::vector<Hypothesis> found;
    propose(&found);
    all.insert(all.end(), found.begin(), found.end());
  };
  add([&](auto* found) { search->ByBirdsEye(found, &stages); });
  add([&](auto* found) { search->ByStructure(found, &stages); });
  add([&](auto* found) { search->ByPlaces(found, &stages); });
  search->ByRepeats(&all, &stages);
  if (search->TurnOver()) {
    add([&](auto* found) { search->ByBirdsEye(found, &stages); });
    add([&](auto* found) { search->ByStructure(found, &stages); });
  }
  return all;
}

std::string OverlapClass(const JudgedPair& pair) {
  if (absl::EndsWith(pair.scenario, "twin") || absl::EndsWith(pair.scenario, "stranger")) return "";
  if (pair.overlap >= 0.3) return "0.30 and more";
  return pair.overlap >= 0.15 ? "0.15-0.30" : "";
}

}  // namespace

JudgedPair JudgeHypotheses(std::vector<DrivenRobot> robots) {
  NameInOrder(&robots);
  const PairTruth truth(robots[0], robots[1]);
  JudgedPair judged;
  if (truth.HasTransform()) {
    judged.overlap = SeenSurface::Overlap(SeenSurface(robots[0]), SeenSurface(robots[1]));
  }
  const matching::PreparedMap a(MapOf(robots[0])), b(MapOf(robots[1]));
  judged.repeats_a = a.self_similarity().degree();
  judged.repeats_b = b.self_similarity().degree();
  matching::CandidateSearch search(a, b);
  std::vector<Hypothesis> proposed = Propose(&search);
  const std::vector<Hypothesis> promising = matching::MostPromising(&proposed);
  for (const Hypothesis& h : proposed) {
    JudgedHypothesis& one = judged.hypotheses.emplace_back();
    one.rigid = one.joint = h;
    one.right = truth.IsWithin(h.T_a_b, kRigidM, kRigidDeg);
    if (truth.HasTransform()) one.error = truth.ErrorOf(h.T_a_b);
    one.is_joint = std::any_of(promising.begin(), promising.end(), [&](const Hypothesis& other) {
      return h.source == other.source && h.T_a_b.Matrix() == other.T_a_b.Matrix();
    });
    if (!one.is_joint) continue;
    search.MeasureRepetition(&one.joint);
    search.MeasureShared(&one.joint);
    matching::MeasurePair(a, b, &one.joint);
    one.joint_right = truth.IsWithin(one.joint.T_a_b, kJointM, kJointDeg);
    one.is_joint = std::none_of(
        judged.hypotheses.begin(), judged.hypotheses.end() - 1, [&](const JudgedHypothesis& other) {
          return other.is_joint && matching::IsSamePlace(one.joint.joint, other.joint.joint);
        });
  }
  return judged;
}

std::string SearchTable(const std::vector<JudgedPair>& pairs) {
  struct Counts {
    int pairs = 0, found = 0;
    std::map<std::string, int> by, only_by;
  };
  std::map<std::string, Counts> classes;
  for (const JudgedPair& pair : pairs) {
    if (OverlapClass(pair).empty()) continue;
    Counts& counts = classes[OverlapClass(pair)];
    ++counts.pairs;
    std::map<std::string, int> sources;
    for (const JudgedHypothesis& h : pair.hypotheses) {
      if (h.right || h.joint_right) ++sources[ToString(h.rigid.source)];
    }
    counts.found += !sources.empty();
    for (const auto& [source, times] : sources) ++counts.by[source];
    if (sources.size() == 1) ++counts.only_by[sources.begin()->first];
  }
  std::string table =
      "| overlap | pairs | right place proposed | by | by this one alone |\n"
      "|---|---|---|---|---|\n";
  const auto list = [](const std::map<std::string, int>& counts) {
    std::string text;
    for (const auto& [name, count] : counts) {
      absl::StrAppend(&text, text.empty() ? "" : ", ", name, " ", count);
    }
    return text;
  };
  for (const auto& [name, counts] : classes) {
    absl::StrAppendFormat(&table, "| %s | %d | %d | %s | %s |\n", name, counts.pairs, counts.found,
                          list(counts.by), list(counts.only_by));
  }
  return table;
}

std::string ToCsv(const std::vector<JudgedPair>& pairs) {
  std::string csv =
      "pair,scenario,seed,overlap_of_truth,outdoors,source,right,is_joint,joint_right,rigid_"
      "overlap,"
      "rigid_inliers,rigid_residual_m,rigid_free_space,rigid_comparisons,free_space,comparisons,"
      "overlap,inlier_ratio,inliers,residual_m,shared_area_m2,shared_share,observability,"
      "odometry_residual,converged,regions,contradicted_regions,upright_ratio,"
      "own_ratio,own_upright_ratio,own_residual_m,own_near,error_m,error_deg,"
      "repeats_a,repeats_b,distinctive,upside_down,things_there,things_gone\n";
  for (size_t i = 0; i < pairs.size(); ++i) {
    const JudgedPair& pair = pairs[i];
    for (const JudgedHypothesis& one : pair.hypotheses) {
      const Hypothesis &r = one.rigid, &h = one.joint;
      absl::StrAppendFormat(&csv, "%d,%s,%d,%.3f,%d,%s,%d,%d,%d,%.4f,%d,%.4f,%.5f,%d,", i,
                            pair.scenario, pair.seed, pair.overlap, r.outdoors, ToString(r.source),
                            one.right, one.is_joint, one.joint_right, r.overlap, r.inliers,
                            r.residual_m, r.free_space.violation(), r.free_space.comparisons());
      absl::StrAppendFormat(&csv, "%.5f,%d,%.4f,%.4f,%d,%.4f,%.0f,%.3f,%.4f,%.3f,%d,",
                            h.free_space.violation(), h.free_space.comparisons(), h.overlap,
                            h.inlier_ratio, h.inliers, h.residual_m, h.shared_area_m2,
                            h.shared_share, h.observability, h.odometry_residual, h.converged);
      absl::StrAppendFormat(&csv, "%d,%d,%.4f,%.4f,%.4f,%.4f,%d,%.2f,%.1f,%.4f,%.4f,",
                            h.free_space.regions, h.free_space.contradicted_regions,
                            h.upright_ratio, h.own.ratio(), h.own.upright_ratio(),
                            h.own.residual_m(), h.own.near, one.error.median_m,
                            one.error.median_deg, pair.repeats_a, pair.repeats_b);
      absl::StrAppend(&csv, h.distinctive, ",", static_cast<int>(h.upside_down), ",",
                      h.things.there, ",", h.things.gone, "\n");
    }
  }
  return csv;
}

}  // namespace isthmus::bench
