#include "server/map/map_view.h"

#include <algorithm>
#include <tuple>

#include "server/map_reader.h"

namespace isthmus::server {
namespace {

placement::Session PlacementSession(const SessionId& id, const SessionView& view) {
  placement::Session session;
  session.tree.session = id;
  double total = 0;
  for (const auto& [index, length] : view.path_length_m) total += length;
  const double mean =
      view.path_length_m.empty() ? 0 : total / static_cast<double>(view.path_length_m.size());
  const SubmapInfo* before = nullptr;
  for (const auto& [index, submap] : view.submaps) {
    placement::Node node;
    node.index = index;
    node.T_odom_submap = submap.T_odom_submap;
    if (before != nullptr) {
      // A retired submap took its path length with it.
      const double* length = view.path_length_m.Find(index - 1);
      node.travelled_m = length == nullptr ? mean : *length;
      if (before->id.index + 1 == index) node.drift_covariance = submap.drift_covariance;
    }
    session.nodes.push_back(node);
    before = &submap;
  }
  return session;
}

}  // namespace

std::shared_ptr<const ComposedMap> MapReader::Map() const { return View()->map; }

const SessionView* MapView::Newest(const RobotId& robot) const {
  const SessionView* newest = nullptr;
  for (const auto& [id, session] : sessions) {
    const SessionRecord& record = session.record;
    if (record.robot != robot || record.segment > 1) continue;
    if (newest == nullptr || record.created_ns >= newest->record.created_ns) newest = &session;
  }
  return newest == nullptr ? nullptr : SegmentsOf(newest->record.id).back();
}

const SessionView* MapView::Named(const RobotId& robot_or_session) const {
  const SessionView* session = Find(SessionId(robot_or_session.value()));
  return session != nullptr ? session : Newest(robot_or_session);
}

std::vector<const SessionView*> MapView::SegmentsOf(const SessionId& opened) const {
  std::vector<const SessionView*> segments;
  // The ids of later segments begin with that of the first, so they are near it.
  for (auto it = sessions.lower_bound(opened); it != sessions.end(); ++it) {
    if (!it.key().value().starts_with(opened.value())) break;
    if (it.value().record.opened() == opened) segments.push_back(&it.value());
  }
  std::sort(segments.begin(), segments.end(),
            [](const auto* a, const auto* b) { return a->record.segment < b->record.segment; });
  return segments;
}

std::vector<const SessionView*> MapView::InOrder() const {
  std::vector<const SessionView*> all;
  for (const auto& [id, session] : sessions) all.push_back(&session);
  const auto place = [this](const SessionView* session) {
    const SessionId& opened = session->record.opened();
    const SessionView* first = Find(opened);
    const int64_t opened_ns = first == nullptr ? 0 : first->record.created_ns;
    return std::tuple(opened_ns, opened, session->record.segment);
  };
  std::sort(all.begin(), all.end(),
            [&](const auto* a, const auto* b) { return place(a) < place(b); });
  return all;
}

const Placement* MapView::PlacementOf(const SessionId& session) const {
  const std::vector<Placement>& all = revision->placements;
  const auto it = std::lower_bound(
      all.begin(), all.end(), session,
      [](const Placement& placement, const SessionId& id) { return placement.session < id; });
  return it == all.end() || it->session != session ? nullptr : &*it;
}

absl::StatusOr<uint32_t> MapView::NumberOf(const MapName& name) const {
  uint32_t count = 0;
  for (const Placement& placement : revision->placements) {
    count = std::max(count, placement.component + 1);
  }
  return isthmus::NumberOf(name, count, [this](const SessionId& session) {
    const Placement* placement = PlacementOf(session);
    return placement == nullptr ? std::nullopt : std::optional<uint32_t>(placement->component);
  });
}

const Match* MapView::EffectiveMatch(const SessionPair& pair) const {
  const auto it = std::lower_bound(effective->begin(), effective->end(), pair,
                                   [](const Match& match, const SessionPair& wanted) {
                                     return SessionPair(match.a, match.b) < wanted;
                                   });
  return it == effective->end() || SessionPair(it->a, it->b) != pair ? nullptr : &*it;
}

std::vector<PlacedSubmap> MapView::PlacedSubmaps() const {
  std::vector<PlacedSubmap> placed;
  for (const Placement& placement : revision->placements) {
    const SessionView* session = Find(placement.session);
    if (session == nullptr) continue;
    for (const SubmapPose& pose : placement.submaps) {
      if (std::shared_ptr<const SubmapInfo> submap = session->submaps.Get(pose.index)) {
        placed.push_back({std::move(submap), placement.component, pose.T_map_submap});
      }
    }
  }
  return placed;
}

std::vector<match_graph::Node> MatchGraphNodes(const MapView& view) {
  std::vector<match_graph::Node> nodes;
  for (const auto& [id, session] : view.sessions) {
    if (session.submaps.empty()) continue;
    match_graph::Node& node = nodes.emplace_back();
    Box box;
    for (const auto& [index, submap] : session.submaps) {
      box.Extend(submap.T_odom_submap.translation());
      node.submaps.emplace_hint(node.submaps.end(), index, submap.T_odom_submap.translation());
    }
    node.session = id;
    node.weight = static_cast<double>(session.points);
    node.center = (box.min + box.max) / 2;
    node.extent_m = (box.max - box.min).norm();
  }
  return nodes;
}

placement::Input PlacementInput(const MapView& view) {
  placement::Input input;
  for (const auto& [id, session] : view.sessions) {
    if (!session.submaps.empty()) input.sessions.push_back(PlacementSession(id, session));
  }
  input.matches = *view.effective;
  for (const auto& [id, loop] : view.loops) input.loops.push_back(loop);
  for (const auto& [submap, anchor] : view.anchors) input.anchors.push_back(anchor);
  return input;
}

}  // namespace isthmus::server
