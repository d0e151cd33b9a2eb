#include "server/threads/session_proximity.h"

#include <algorithm>
#include <set>

#include "server/threads/limits.h"

namespace isthmus::server {

SessionProximity::SessionProximity(const MapView& view) {
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(kNearSessionsM / 2);
  for (const Placement& placement : view.revision->placements) {
    Place& place = places_[placement.session];
    place.component = placement.component;
    for (const SubmapPose& pose : placement.submaps) {
      const Eigen::Vector2d at = pose.T_map_submap.translation().head<2>();
      place.extent.extend(Eigen::AlignedBox2d(at - margin, at + margin));
    }
  }
  std::set<uint32_t> anchored;
  for (const auto& [submap, anchor] : view.anchors) {
    const auto it = places_.find(submap.session);
    if (it != places_.end()) anchored.insert(it->second.component);
  }
  for (auto& [session, place] : places_) place.is_anchored = anchored.contains(place.component);
}

bool SessionProximity::AreJoined(const SessionPair& pair) const {
  const auto a = places_.find(pair.first), b = places_.find(pair.second);
  return a != places_.end() && b != places_.end() && a->second.component == b->second.component;
}

bool SessionProximity::IsAnchored(const SessionId& session) const {
  const auto it = places_.find(session);
  return it != places_.end() && it->second.is_anchored;
}

double SessionProximity::Nearness(const SessionPair& pair) const {
  const auto a = places_.find(pair.first), b = places_.find(pair.second);
  return a == places_.end() || b == places_.end() ? 0 : Nearness(a->second, b->second);
}

double SessionProximity::Nearness(const Place& a, const Place& b) {
  if (a.component != b.component && !(a.is_anchored && b.is_anchored)) return 0;
  const Eigen::AlignedBox2d common = a.extent.intersection(b.extent);
  if (common.isEmpty()) return 0;
  return common.volume() / std::min(a.extent.volume(), b.extent.volume());
}

std::optional<SessionId> SessionProximity::NearestJoined(
    const SessionId& session, const std::function<bool(const SessionId&)>& is_wanted) const {
  const auto it = places_.find(session);
  if (it == places_.end()) return std::nullopt;
  std::optional<SessionId> nearest;
  double most = 0;
  for (const auto& [other, place] : places_) {
    if (place.component != it->second.component || other == session) continue;
    const double nearness = Nearness(it->second, place);
    if (nearness <= most || !is_wanted(other)) continue;
    most = nearness;
    nearest = other;
  }
  return nearest;
}

}  // namespace isthmus::server
