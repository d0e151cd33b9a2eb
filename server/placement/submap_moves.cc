#include "server/placement/placer.h"

namespace isthmus::placement {
namespace {

struct Place {
  SessionId frame;
  Pose T_map_submap;
};

bool IsSame(const Place& a, const Place& b) {
  return a.frame == b.frame && a.T_map_submap.translation() == b.T_map_submap.translation() &&
         a.T_map_submap.rotation().coeffs() == b.T_map_submap.rotation().coeffs();
}

std::map<SubmapId, Place> PlacesOf(const std::vector<Placement>& placements) {
  std::map<SubmapId, Place> places;
  for (const Placement& placement : placements) {
    for (const SubmapPose& submap : placement.submaps) {
      places[{placement.session, submap.index}] = {placement.reference, submap.T_map_submap};
    }
  }
  return places;
}

}  // namespace

std::vector<SubmapMove> FindMoves(const std::vector<Placement>& before,
                                  const std::vector<Placement>& after) {
  const std::map<SubmapId, Place> old_places = PlacesOf(before);
  std::map<SubmapId, Place> new_places = PlacesOf(after);
  std::map<SubmapId, SubmapMove> moves;
  for (const auto& [id, place] : old_places) {
    const auto now = new_places.find(id);
    if (now != new_places.end() && IsSame(place, now->second)) {
      new_places.erase(now);
      continue;
    }
    SubmapMove& move = moves[id];
    move.before = place.T_map_submap;
    move.frame_before = place.frame;
  }
  for (const auto& [id, place] : new_places) {
    SubmapMove& move = moves[id];
    move.after = place.T_map_submap;
    move.frame_after = place.frame;
  }
  std::vector<SubmapMove> list;
  for (auto& [id, move] : moves) {
    move.submap = id;
    list.push_back(std::move(move));
  }
  return list;
}

}  // namespace isthmus::placement
