#include "client/cli/graph_json.h"

#include "client/cli/moves_text.h"

namespace isthmus::cli {
namespace {

Json PoseOrNull(const std::optional<Pose>& pose) { return pose ? ToJson(*pose) : Json(nullptr); }

Json NameOrNull(const SessionId& session) {
  return session.empty() ? Json(nullptr) : Json(session.value());
}

// Numbers that were not computed are -1 in the API and null here.
template <typename T>
Json OrNull(T value) {
  return value >= 0 ? Json(value) : Json(nullptr);
}

}  // namespace

Json ToJson(const RevisionInfo& revision) {
  Json matches = Json::array();
  for (const auto& [a, b] : revision.matches) {
    matches.push_back({{"session_a", a.value()}, {"session_b", b.value()}});
  }
  return {{"revision", revision.revision},
          {"stamp_ns", revision.stamp_ns},
          {"cause", revision.cause},
          {"matches", std::move(matches)},
          {"loops", revision.loops},
          {"added", revision.added},
          {"moved", revision.moved},
          {"removed", revision.removed},
          {"largest_move_m", revision.largest_move_m}};
}

Json ToJson(const SubmapMove& move) {
  const std::optional<MoveSize> size = SizeOf(move);
  return {{"session", move.submap.session.value()},
          {"index", move.submap.index},
          {"before", PoseOrNull(move.before)},
          {"reference_before", NameOrNull(move.frame_before)},
          {"after", PoseOrNull(move.after)},
          {"reference_after", NameOrNull(move.frame_after)},
          {"move_m", size ? Json(size->metres) : Json(nullptr)},
          {"move_deg", size ? Json(size->degrees) : Json(nullptr)}};
}

Json ToJson(const RevisionDiff& diff) {
  Json out = {{"from_revision", diff.from},
              {"to_revision", diff.to},
              {"revisions", Json::array()},
              {"moves", Json::array()}};
  for (const RevisionInfo& revision : diff.revisions) out["revisions"].push_back(ToJson(revision));
  for (const SubmapMove& move : diff.moves) out["moves"].push_back(ToJson(move));
  return out;
}

Json ToJson(const Loop& record, bool with_edges) {
  const LoopClosure& loop = record.loop;
  Json out = {{"id", loop.id},
              {"session", loop.session.value()},
              {"robot", record.robot.value()},
              {"submap_a", loop.submap_a},
              {"submap_b", loop.submap_b},
              {"T_a_b", ToJson(loop.T_a_b)},
              {"confidence", OrNull(loop.confidence)},
              {"overlap", OrNull(loop.overlap)},
              {"residual_m", OrNull(loop.residual_m)},
              {"free_space", OrNull(loop.free_space)},
              {"comparisons", OrNull(loop.comparisons)},
              {"source", ToString(loop.source)},
              {"detail", loop.detail},
              {"computed_ns", loop.computed_ns},
              {"rejected", loop.rejected},
              {"note", loop.note},
              {"edge_count", record.edge_count},
              {"edges_used", record.edges_used}};
  if (with_edges) {
    out["edges"] = Json::array();
    for (const SubmapEdge& edge : loop.edges) out["edges"].push_back(ToJson(edge));
  }
  return out;
}

Json ToJson(const RobotAnchor& record) {
  const Anchor& anchor = record.anchor;
  return {{"session", anchor.submap.session.value()},
          {"index", anchor.submap.index},
          {"robot", record.robot.value()},
          {"T_map_submap", ToJson(anchor.T_map_submap)},
          {"sigma_xy_m", anchor.sigma_xy_m},
          {"sigma_z_m", anchor.sigma_z_m},
          {"sigma_deg", anchor.sigma_deg},
          {"note", anchor.note},
          {"given_ns", anchor.given_ns}};
}

}  // namespace isthmus::cli
