// Places of the sessions in the map, as boxes around their ways, to tell the ones that may have
// seen the same.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>

#include "server/map/map_view.h"

namespace isthmus::server {

// The sessions at the view's revision. Value type.
class SessionProximity {
 public:
  explicit SessionProximity(const MapView& view);

  bool AreJoined(const SessionPair& pair) const;
  // Anchors say where its component lies on Earth.
  bool IsAnchored(const SessionId& session) const;
  // Share of the smaller box that both have in common, (0, 1], a box being kNearSessionsM / 2
  // larger on all sides than the way. 0 where they are apart, or have no frame in common: a
  // component has one, and all that are anchored.
  double Nearness(const SessionPair& pair) const;
  // The nearest, by the above, of the sessions of its component that are near it and wanted.
  std::optional<SessionId> NearestJoined(
      const SessionId& session, const std::function<bool(const SessionId&)>& is_wanted) const;

 private:
  struct Place {
    uint32_t component = 0;
    bool is_anchored = false;
    Eigen::AlignedBox2d extent = {};
  };

  static double Nearness(const Place& a, const Place& b);

  std::map<SessionId, Place> places_;
};

}  // namespace isthmus::server
