// The anchors of a view by session.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/map/anchor.h"
#include "server/map/map_view.h"

namespace isthmus::server {

class KnownAnchors {
 public:
  explicit KnownAnchors(const MapView& view) {
    for (const auto& [submap, anchor] : view.anchors) {
      by_session_[submap.session].push_back(anchor);
    }
  }

  // In order of their submaps; none where only one of the sessions has some.
  std::vector<Anchor> Of(const SessionPair& pair) const {
    const auto a = by_session_.find(pair.first), b = by_session_.find(pair.second);
    if (a == by_session_.end() || b == by_session_.end()) return {};
    std::vector<Anchor> anchors = a->second;
    anchors.insert(anchors.end(), b->second.begin(), b->second.end());
    return anchors;
  }

  // Another number once these are others.
  uint64_t Version(const SessionPair& pair) const {
    uint64_t version = 0;
    for (const Anchor& anchor : Of(pair)) version = 31 * version + uint64_t(anchor.given_ns) + 1;
    return version;
  }

 private:
  std::map<SessionId, std::vector<Anchor>> by_session_;
};

}  // namespace isthmus::server
