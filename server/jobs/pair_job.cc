#include "server/jobs/pair_job.h"

#include "core/io/crc32c.h"
#include "server/jobs/record_stream.h"

namespace isthmus {

using server::Is;

// The fields of what is sent, in its order. All of them: what is left out is lost.

void Fields(auto& stream, Is<StageTime> auto& stage) { stream(stage.stage, stage.ms); }

void Fields(auto& stream, Is<SubmapEdge> auto& edge) {
  stream(edge.submap_a, edge.submap_b, edge.T_a_b, edge.information);
}

void Fields(auto& stream, Is<RivalMatch> auto& rival) {
  stream(rival.T_a_b, rival.state, rival.reason, rival.confidence, rival.matcher, rival.overlap,
         rival.free_space, rival.comparisons, rival.shared_area_m2, rival.edges);
}

void Fields(auto& stream, Is<Match> auto& match) {
  stream(match.a, match.b, match.T_a_b, match.state, match.reason, match.detail, match.confidence,
         match.overlap, match.inliers, match.inlier_ratio, match.residual_m, match.free_space,
         match.comparisons, match.runner_up, match.shared_area_m2, match.observability,
         match.odometry_residual, match.cycle_m, match.cycle_deg, match.candidates, match.matcher,
         match.submaps_a, match.submaps_b, match.computed_ns, match.stages, match.edges,
         match.rivals);
}

void Fields(auto& stream, Is<SubmapId> auto& id) { stream(id.session, id.index); }

void Fields(auto& stream, Is<Anchor> auto& anchor) {
  stream(anchor.submap, anchor.T_map_submap, anchor.sigma_xy_m, anchor.sigma_z_m, anchor.sigma_deg,
         anchor.note, anchor.given_ns);
}

namespace pose_graph {

void Fields(auto& stream, Is<Edge> auto& edge) {
  stream(edge.a, edge.b, edge.T_a_b, edge.information, edge.may_be_wrong, edge.weight);
}

}  // namespace pose_graph

namespace matching {

void Fields(auto& stream, Is<SessionShape> auto& shape) {
  stream(shape.edges, shape.best, shape.odometry);
}

void Fields(auto& stream, Is<MatcherOptions> auto& options) {
  stream(options.search, options.min_probability, options.max_enclosed_share,
         options.min_enclosed_area_m2, options.min_observability, options.max_odometry_residual);
}

}  // namespace matching

namespace server {

void Fields(auto& stream, Is<MapOfJob> auto& map) {
  stream(map.session, map.submaps, map.stamps_ns, map.T_odom_submap, map.shape);
}

void Fields(auto& stream, Is<PairJob> auto& job) {
  stream(job.a, job.b, job.anchors, job.known, job.options, job.search, job.posted_ns);
}

namespace {

template <typename Record>
std::string Encode(const Record& record) {
  RecordWriter writer;
  writer(record);
  std::string bytes;
  AppendBytes(io::Crc32c(writer.bytes().data(), writer.bytes().size()), bytes);
  return bytes + writer.bytes();
}

template <typename Record>
absl::StatusOr<Record> Decode(const std::string& bytes) {
  ByteReader head(bytes);
  const auto checksum = head.Read<uint32_t>();
  const std::string body = head.Rest();
  Record record;
  RecordReader reader(body);
  if (head.ok() && checksum == io::Crc32c(body.data(), body.size())) {
    reader(record);
    if (reader.ok()) return record;
  }
  return absl::DataLossError("it is damaged, or of another version");
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

std::string EncodePairJob(const PairJob& job) { return Encode(job); }

absl::StatusOr<PairJob> DecodePairJob(const std::string& bytes) {
  absl::StatusOr<PairJob> job = Decode<PairJob>(bytes);
  if (!job.ok() || (IsWhole(job->a) && IsWhole(job->b))) return job;
  return absl::DataLossError("its maps are not whole");
}

std::string EncodeMatch(const Match& match) { return Encode(match); }
absl::StatusOr<Match> DecodeMatch(const std::string& bytes) { return Decode<Match>(bytes); }

}  // namespace server
}  // namespace isthmus
