// The feed of changes from one composed map to the next.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "core/records/map_changes.h"

namespace isthmus::server {

// Thread safe.
class MapFeed {
 public:
  virtual ~MapFeed() = default;

  // The step from `known` to the newest map, in tiles of that level, in those of their last for
  // components with fewer levels; everything where `known` says nothing, or too little is known of
  // it by now. Nothing while there is no map. Without `robots`.
  virtual std::optional<MapStep> Since(const MapMark& known, uint32_t level) = 0;

  // `wake` is called, from any thread, after each new map; it must not block. Once Forget returns,
  // or while it does, one last call may be under way.
  virtual uint64_t OnChange(std::function<void()> wake) = 0;
  virtual void Forget(uint64_t handle) = 0;
};

}  // namespace isthmus::server
