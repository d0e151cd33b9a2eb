#include "server/jobs/job.h"

#include <absl/strings/str_cat.h>

#include <algorithm>

#include "core/state_codec.h"

namespace isthmus {

// The fields of what is sent, in its order. All of them: what is left out is lost.

void Fields(IsRecord<StageTime> auto& stage, auto& io) { io(stage.stage, stage.ms); }

void Fields(IsRecord<SubmapEdge> auto& edge, auto& io) {
  io(edge.submap_a, edge.submap_b, edge.T_a_b, edge.information);
}

void Fields(IsRecord<RivalMatch> auto& rival, auto& io) {
  io(rival.T_a_b, rival.state, rival.reason, rival.confidence, rival.matcher, rival.overlap,
     rival.free_space, rival.comparisons, rival.shared_area_m2, rival.edges);
}

void Fields(IsRecord<Match> auto& match, auto& io) {
  io(match.a, match.b, match.T_a_b, match.state, match.reason, match.detail, match.confidence,
     match.overlap, match.inliers, match.inlier_ratio, match.residual_m, match.free_space,
     match.comparisons, match.runner_up, match.shared_area_m2, match.observability,
     match.odometry_residual, match.cycle_m, match.cycle_deg, match.candidates, match.matcher,
     match.submaps_a, match.submaps_b, match.computed_ns, match.stages, match.edges, match.rivals);
}

void Fields(IsRecord<SubmapId> auto& id, auto& io) { io(id.session, id.index); }

void Fields(IsRecord<Anchor> auto& anchor, auto& io) {
  io(anchor.submap, anchor.T_map_submap, anchor.sigma_xy_m, anchor.sigma_z_m, anchor.sigma_deg,
     anchor.note, anchor.given_ns);
}

void Fields(IsRecord<LoopClosure> auto& loop, auto& io) {
  io(loop.id, loop.session, loop.submap_a, loop.submap_b, loop.T_a_b, loop.confidence, loop.overlap,
     loop.residual_m, loop.free_space, loop.comparisons, loop.source, loop.detail, loop.computed_ns,
     loop.edges, loop.rejected, loop.note);
}

namespace pose_graph {

void Fields(IsRecord<DriftModel> auto& drift, auto& io) {
  io(drift.position_m, drift.position_per_m, drift.rotation_rad, drift.rotation_per_m,
     drift.rotation_per_rad);
}

void Fields(IsRecord<Edge> auto& edge, auto& io) {
  io(edge.a, edge.b, edge.T_a_b, edge.information, edge.may_be_wrong, edge.weight);
}

}  // namespace pose_graph

namespace matching {

void Fields(IsRecord<SessionShape> auto& shape, auto& io) {
  io(shape.edges, shape.best, shape.odometry);
}

void Fields(IsRecord<MatcherOptions> auto& options, auto& io) {
  io(options.search, options.min_probability, options.twins, options.min_observability,
     options.max_odometry_residual, options.first_look);
}

void Fields(IsRecord<LoopOptions> auto& options, auto& io) {
  io(options.enabled, options.min_path_length_m, options.drift, options.drift_sigmas,
     options.min_overlap, options.min_comparisons, options.max_free_space,
     options.max_free_space_outdoors, options.min_margin, options.min_observability,
     options.max_odometry_residual, options.max_edges, options.prepared_submaps);
}

void Fields(IsRecord<LoopMemory::Failure> auto& failure, auto& io) {
  io(failure.old_path_length, failure.new_path_length);
}

void Fields(IsRecord<LoopMemory> auto& memory, auto& io) {
  std::vector<uint32_t> indices;
  std::vector<double> radii_m;
  for (const auto& [index, radius_m] : memory.radii_m) {
    indices.push_back(index);
    radii_m.push_back(radius_m);
  }
  io(memory.failures, indices, radii_m);
  if constexpr (std::remove_cvref_t<decltype(io)>::kIsReading) {
    io.Expect(indices.size() == radii_m.size());
    for (size_t i = 0; io.ok() && i < indices.size(); ++i) {
      memory.radii_m.emplace(indices[i], radii_m[i]);
    }
  }
}

}  // namespace matching

namespace server {

void Fields(IsRecord<MapOfJob> auto& map, auto& io) {
  io(map.session, map.submaps, map.stamps_ns, map.T_odom_submap, map.shape);
}

void Fields(IsRecord<PairJob> auto& job, auto& io) {
  io(job.a, job.b, job.anchors, job.known, job.options, job.search, job.posted_ns);
}

void Fields(IsRecord<PlanJob> auto& job, auto& io) { io(job.session, job.others); }

void Fields(IsRecord<LoopJob> auto& job, auto& io) {
  io(job.session, job.T_map_submap, job.first_new, job.known, job.memory, job.options);
}

void Fields(IsRecord<LoopResult> auto& result, auto& io) { io(result.found, result.memory); }

namespace {

// Format. Jobs name the version of the program, so there is no other of the layout.
constexpr char kMap[] = "IMJm", kPair[] = "IMJp", kMatch[] = "IMJr", kPlan[] = "IMJi",
               kScores[] = "IMJs", kLoops[] = "IMJl", kFound[] = "IMJf";
constexpr uint32_t kVersion = 1;  // Format.

template <typename Record>
std::string Encode(const char* kind, const Record& record) {
  StateWriter writer;
  writer(record);
  return SealState(kind, kVersion, 0, writer.Take());
}

template <typename Record>
absl::StatusOr<Record> Decode(const char* kind, const std::string& bytes, const std::string& name) {
  absl::StatusOr<StateReader> reader = OpenState(kind, kVersion, 0, bytes, name);
  if (!reader.ok()) return reader.status();
  Record record;
  (*reader)(record);
  if (reader->ok() && reader->remaining() == 0) return record;
  return absl::DataLossError(absl::StrCat("these are not the bytes of ", name));
}

// Poses and submaps, and the nodes of a shape, are as many.
bool IsWhole(const MapOfJob& map) {
  const size_t count = map.submaps.size();
  if (map.T_odom_submap.size() != count || map.stamps_ns.size() != count) return false;
  if (!map.shape) return true;
  if (map.shape->best.size() != count || map.shape->odometry.size() != count) return false;
  for (const pose_graph::Edge& edge : map.shape->edges) {
    if (edge.a < 0 || edge.b < 0 || static_cast<size_t>(edge.a) >= count ||
        static_cast<size_t>(edge.b) >= count) {
      return false;
    }
  }
  return true;
}

}  // namespace

MapOfJob MakeMapOfJob(const SessionId& session, const matching::SubmapList& submaps) {
  MapOfJob map;
  map.session = session;
  for (const auto& submap : submaps) {
    map.submaps.push_back(submap->id.index);
    map.stamps_ns.push_back(submap->first_stamp_ns);
    map.T_odom_submap.push_back(submap->T_odom_submap);
  }
  return map;
}

std::string EncodeMap(const MapOfJob& map) { return Encode(kMap, map); }
std::string EncodePairJob(const PairJob& job) { return Encode(kPair, job); }

absl::StatusOr<PairJob> DecodePairJob(const std::string& bytes) {
  absl::StatusOr<PairJob> job = Decode<PairJob>(kPair, bytes, "the match of a pair");
  if (!job.ok() || (IsWhole(job->a) && IsWhole(job->b))) return job;
  return absl::DataLossError("its maps are not whole");
}

std::string EncodePlanJob(const PlanJob& job) { return Encode(kPlan, job); }

absl::StatusOr<PlanJob> DecodePlanJob(const std::string& bytes) {
  absl::StatusOr<PlanJob> job = Decode<PlanJob>(kPlan, bytes, "the comparison of plans");
  if (!job.ok() ||
      (IsWhole(job->session) && std::all_of(job->others.begin(), job->others.end(), IsWhole))) {
    return job;
  }
  return absl::DataLossError("its maps are not whole");
}

bool IsPlanJob(const std::string& bytes) { return bytes.starts_with(kPlan); }

std::string EncodeLoopJob(const LoopJob& job) { return Encode(kLoops, job); }

absl::StatusOr<LoopJob> DecodeLoopJob(const std::string& bytes) {
  absl::StatusOr<LoopJob> job = Decode<LoopJob>(kLoops, bytes, "the search for loops");
  if (!job.ok()) return job;
  const size_t count = job->session.submaps.size();
  if (IsWhole(job->session) && job->T_map_submap.size() == count && job->first_new < count) {
    return job;
  }
  return absl::DataLossError("its map is not whole");
}

bool IsLoopJob(const std::string& bytes) { return bytes.starts_with(kLoops); }

std::string EncodeMatch(const Match& match) { return Encode(kMatch, match); }
absl::StatusOr<Match> DecodeMatch(const std::string& bytes) {
  return Decode<Match>(kMatch, bytes, "a match");
}

std::string EncodePlanScores(const PlanScores& scores) { return Encode(kScores, scores); }
absl::StatusOr<PlanScores> DecodePlanScores(const std::string& bytes) {
  return Decode<PlanScores>(kScores, bytes, "scores of plans");
}

std::string EncodeLoopResult(const LoopResult& result) { return Encode(kFound, result); }
absl::StatusOr<LoopResult> DecodeLoopResult(const std::string& bytes) {
  return Decode<LoopResult>(kFound, bytes, "loops that were found");
}

}  // namespace server
}  // namespace isthmus
