// The anchors of a view by session.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/map/anchor.h"
#include "server/map/map_view.h"

namespace isthmus::server {

// Looked at for every pair before any is matched: nothing is copied. The view must outlive it.
class AnchorIndex {
 public:
  explicit AnchorIndex(const MapView& view) {
    for (const auto& [submap, anchor] : view.anchors) {
      OfSession& known = by_session_[submap.session];
      known.anchors.push_back(&anchor);
      known.version = 31 * known.version + static_cast<uint64_t>(anchor.given_ns) + 1;
    }
  }

  // In order of their submaps; none where only one of the sessions has some.
  std::vector<Anchor> Of(const SessionPair& pair) const {
    std::vector<Anchor> anchors;
    for (const OfSession* known : Both(pair)) {
      for (const Anchor* anchor : known->anchors) anchors.push_back(*anchor);
    }
    return anchors;
  }

  // Another number once these are others.
  uint64_t Version(const SessionPair& pair) const {
    uint64_t version = 0;
    for (const OfSession* known : Both(pair)) version = 31 * version + known->version;
    return version;
  }

 private:
  struct OfSession {
    std::vector<const Anchor*> anchors;
    uint64_t version = 0;
  };

  // The anchors of both sessions, or nothing.
  std::vector<const OfSession*> Both(const SessionPair& pair) const {
    const auto a = by_session_.find(pair.first), b = by_session_.find(pair.second);
    if (a == by_session_.end() || b == by_session_.end()) return {};
    return {&a->second, &b->second};
  }

  std::map<SessionId, OfSession> by_session_;
};

}  // namespace isthmus::server
