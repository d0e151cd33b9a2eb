#include "server/jobs/job.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "core/state_codec.h"

namespace isthmus {

// The fields of all that is sent, in its order. All of them: a field left out is lost.

void Fields(IsRecord<StageTime> auto& stage, auto& io) { io(stage.stage, stage.ms); }

void Fields(IsRecord<SubmapEdge> auto& edge, auto& io) {
  io(edge.submap_a, edge.submap_b, edge.T_a_b, edge.information);
}

void Fields(IsRecord<RivalMatch> auto& rival, auto& io) {
  io(rival.T_a_b, rival.state, rival.reason, rival.confidence, rival.matcher, rival.overlap,
     rival.free_space, rival.comparisons, rival.shared_area_m2, rival.edges);
}

void Fields(IsRecord<WayPoint> auto& point, auto& io) { io(point.submap, point.position); }

void Fields(IsRecord<AskedDrive> auto& drive, auto& io) {
  io(drive.by_b, drive.rival, drive.way, drive.leaves_own, drive.length_m, drive.confidence);
}

void Fields(IsRecord<Match> auto& match, auto& io) {
  io(match.a, match.b, match.T_a_b, match.state, match.reason, match.detail, match.confidence,
     match.overlap, match.inliers, match.inlier_ratio, match.residual_m, match.free_space,
     match.comparisons, match.runner_up, match.shared_area_m2, match.observability,
     match.odometry_residual, match.cycle_m, match.cycle_deg, match.candidates, match.matcher,
     match.submaps_a, match.submaps_b, match.computed_ns, match.stages, match.edges, match.rivals,
     match.asked);
}

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

void Fields(IsRecord<FreeSpaceScore> auto& score, auto& io) {
  io(score.agree, score.front, score.regions, score.contradicted_regions);
}

void Fields(IsRecord<SurfaceAgreement> auto& surface, auto& io) {
  io(surface.asked, surface.near, surface.on, surface.squared_m2, surface.near_upright,
     surface.on_upright, surface.on_distinctive, surface.scatter);
}

void Fields(IsRecord<ThingAgreement> auto& things, auto& io) { io(things.there, things.gone); }

void Fields(IsRecord<JointRefinement> auto& joint, auto& io) {
  io(joint.poses.a, joint.poses.b, joint.edges, joint.odometry_residual, joint.T_a_b, joint.ties);
}

void Fields(IsRecord<PositionPair> auto& pair, auto& io) { io(pair.a, pair.b); }

void Fields(IsRecord<MeetingMemory> auto& memory, auto& io) {
  io(memory.asked_a, memory.asked_b, memory.in_vain);
}

void Fields(IsRecord<Hypothesis> auto& h, auto& io) {
  io(h.source, h.outdoors, h.T_a_b, h.converged, h.free_space, h.max_free_space, h.overlap,
     h.inliers, h.inlier_ratio, h.residual_m, h.distinctive, h.things, h.upright_ratio, h.own,
     h.can_be_refuted, h.upside_down, h.at_anchors, h.by_anchors, h.repetition, h.shared_area_m2,
     h.shared_share, h.observability, h.odometry_residual, h.joint, h.shared_center, h.moving_is_b,
     h.agreement, h.things_a, h.things_b, h.meetings);
}

// Outlines, of which a matcher asks no more.
void OutlineFields(IsRecord<SessionMap> auto& map, auto& io) {
  server::JobMapInput outline = server::MakeJobMapInput(map.session, map.submaps);
  io(outline.session, outline.submaps, outline.stamps_ns, outline.T_odom_submap);
  if constexpr (std::remove_cvref_t<decltype(io)>::kIsReading) {
    const size_t count = outline.submaps.size();
    io.Expect(outline.stamps_ns.size() == count && outline.T_odom_submap.size() == count);
    map.session = outline.session;
    for (size_t k = 0; io.ok() && k < count; ++k) {
      auto submap = std::make_shared<Submap>();
      submap->id = {outline.session, outline.submaps[k]};
      submap->first_stamp_ns = outline.stamps_ns[k];
      submap->T_odom_submap = outline.T_odom_submap[k];
      map.submaps.push_back(std::move(submap));
    }
  }
}

void Fields(IsRecord<PairMemory> auto& memory, auto& io) {
  OutlineFields(memory.a, io);
  OutlineFields(memory.b, io);
  io(memory.hypotheses, memory.accepted, memory.lacks_ground, memory.searched, memory.come,
     memory.searched_guess);
}

// A shared one, which may be null.
void SharedFields(auto& memory, auto& io) {
  bool is_there = memory != nullptr;
  io(is_there);
  if (!is_there) return;
  if constexpr (std::remove_cvref_t<decltype(io)>::kIsReading) {
    auto read = std::make_shared<PairMemory>();
    io(*read);
    memory = std::move(read);
  } else {
    io(*memory);
  }
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

void Fields(IsRecord<JobMapInput> auto& map, auto& io) {
  io(map.session, map.submaps, map.stamps_ns, map.T_odom_submap, map.shape);
}

void Fields(IsRecord<PairJob> auto& job, auto& io) {
  io(job.a, job.b, job.anchors, job.known, job.options, job.loops, job.search, job.posted_ns);
  matching::SharedFields(job.memory, io);
}

void Fields(IsRecord<PairResult> auto& result, auto& io) {
  io(result.match);
  matching::SharedFields(result.memory, io);
}

void Fields(IsRecord<PlanJob> auto& job, auto& io) { io(job.session, job.others); }

void Fields(IsRecord<LoopJob> auto& job, auto& io) {
  io(job.session, job.T_map_submap, job.first_new, job.known, job.memory, job.options);
}

void Fields(IsRecord<PlanScore> auto& plan, auto& io) { io(plan.other, plan.score); }

void Fields(IsRecord<LoopResult> auto& result, auto& io) { io(result.found, result.memory); }

namespace {

// Format. Jobs name the version of the program, so there is no other of the layout.
template <typename Record>
constexpr const char* kKind = nullptr;  // Format.
template <>
constexpr const char* kKind<JobMapInput> = "IMJm";  // Format.
template <>
constexpr const char* kKind<PairJob> = "IMJp";  // Format.
template <>
constexpr const char* kKind<PairResult> = "IMJr";  // Format.
template <>
constexpr const char* kKind<PlanJob> = "IMJi";  // Format.
template <>
constexpr const char* kKind<PlanScores> = "IMJs";  // Format.
template <>
constexpr const char* kKind<LoopJob> = "IMJl";  // Format.
template <>
constexpr const char* kKind<LoopResult> = "IMJf";  // Format.
constexpr uint32_t kVersion = 1;                   // Format.

template <typename Record>
std::string Encode(const Record& record) {
  StateWriter writer;
  writer(record);
  return SealState(kKind<Record>, kVersion, 0, writer.Take());
}

template <typename Record>
absl::StatusOr<Record> Decode(const std::string& bytes) {
  absl::StatusOr<StateReader> reader =
      OpenState(kKind<Record>, kVersion, 0, bytes, "a job's bytes");
  if (!reader.ok()) return reader.status();
  Record record;
  (*reader)(record);
  if (reader->ok() && reader->remaining() == 0) return record;
  return absl::DataLossError("these are not a job's bytes");
}

// Poses and submaps, and the nodes of a shape, are as many.
bool IsWhole(const JobMapInput& map) {
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

// True if all that is remembered by submap fits the remembered submaps.
bool IsWhole(const matching::PairMemory& memory) {
  const size_t a = memory.a.submaps.size(), b = memory.b.submaps.size();
  const auto is_of = [](const auto& by_submap, size_t count) {
    return by_submap.empty() || by_submap.size() == count;
  };
  const auto is_between = [&](const SubmapEdge& edge) {
    return edge.submap_a < a && edge.submap_b < b;
  };
  return std::ranges::all_of(memory.hypotheses, [&](const matching::Hypothesis& h) {
    return h.joint.poses.a.size() == a && h.joint.poses.b.size() == b &&
           is_of(h.agreement, h.moving_is_b ? b : a) && is_of(h.things_a, a) &&
           is_of(h.things_b, b) && std::ranges::all_of(h.joint.edges, is_between) &&
           std::ranges::all_of(h.joint.ties, is_between) && h.meetings.asked_a <= a &&
           h.meetings.asked_b <= b &&
           std::ranges::all_of(h.meetings.in_vain,
                               [&](const auto& pair) { return pair.a < a && pair.b < b; });
  });
}

bool IsWhole(const PairJob& job) {
  return IsWhole(job.a) && IsWhole(job.b) && (!job.memory || IsWhole(*job.memory));
}

bool IsWhole(const PlanJob& job) {
  return IsWhole(job.session) && std::all_of(job.others.begin(), job.others.end(),
                                             [](const JobMapInput& map) { return IsWhole(map); });
}

bool IsWhole(const LoopJob& job) {
  const size_t count = job.session.submaps.size();
  return IsWhole(job.session) && job.T_map_submap.size() == count && job.first_new < count;
}

template <typename Record>
absl::StatusOr<Job> DecodeWhole(const std::string& bytes) {
  absl::StatusOr<Record> job = Decode<Record>(bytes);
  if (!job.ok()) return job.status();
  if (!IsWhole(*job)) return absl::DataLossError("its maps are not whole");
  return *std::move(job);
}

}  // namespace

JobMapInput MakeJobMapInput(const SessionId& session, const matching::SubmapList& submaps) {
  JobMapInput map;
  map.session = session;
  for (const auto& submap : submaps) {
    map.submaps.push_back(submap->id.index);
    map.stamps_ns.push_back(submap->first_stamp_ns);
    map.T_odom_submap.push_back(submap->T_odom_submap);
  }
  return map;
}

JobKey KeyOfJob(const Job& job) {
  if (const auto* pair = std::get_if<PairJob>(&job)) {
    return MatchKey{{pair->a.session, pair->b.session}};
  }
  if (const auto* plans = std::get_if<PlanJob>(&job)) return IndexKey{plans->session.session};
  const JobMapInput& map = std::get<LoopJob>(job).session;
  return LoopKey{{map.session, map.submaps.back()}};
}

std::string EncodeMap(const JobMapInput& map) { return Encode(map); }

std::string EncodeJob(const Job& job) {
  return std::visit([](const auto& record) { return Encode(record); }, job);
}

absl::StatusOr<Job> DecodeJob(const std::string& bytes) {
  if (bytes.starts_with(kKind<LoopJob>)) return DecodeWhole<LoopJob>(bytes);
  if (bytes.starts_with(kKind<PlanJob>)) return DecodeWhole<PlanJob>(bytes);
  return DecodeWhole<PairJob>(bytes);
}

std::string EncodeResult(const JobResult& result) {
  return std::visit([](const auto& record) { return Encode(record); }, result);
}

absl::StatusOr<JobResult> DecodeResult(const JobKey& key, const std::string& bytes) {
  if (std::holds_alternative<MatchKey>(key)) return Decode<PairResult>(bytes);
  if (std::holds_alternative<IndexKey>(key)) return Decode<PlanScores>(bytes);
  if (std::holds_alternative<LoopKey>(key)) return Decode<LoopResult>(bytes);
  return absl::InvalidArgumentError("no job of workers has this name");
}

}  // namespace server
}  // namespace isthmus
