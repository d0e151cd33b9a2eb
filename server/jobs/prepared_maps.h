// Sessions' maps made ready for matching, the latest used of them kept.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "core/lru_cache.h"
#include "server/matching/prepared/prepared_map.h"
#include "server/matching/prepared/session_shape.h"

namespace isthmus::server {

// A session as it is matched.
struct ShapedMap {
  SessionMap map;
  std::shared_ptr<const matching::SessionShape> shape;  // Null without loops.
};

// Not thread safe.
class PreparedMaps {
 public:
  using Prepared = std::shared_ptr<const matching::PreparedMap>;

  // They may take `max_bytes`, without the two used last.
  PreparedMaps(matching::SubmapSource source, size_t max_bytes)
      : source_(std::move(source)), max_bytes_(max_bytes) {}

  // Made once, grown with the map. Lets go of maps that were not used for long.
  Prepared Get(const ShapedMap& shaped);
  template <typename Predicate>
  void ForgetIf(const Predicate& goes) {
    prepared_.EraseIf(goes);
  }
  uint64_t bytes() const { return prepared_.weight(); }

 private:
  const matching::SubmapSource source_;
  const size_t max_bytes_;
  LruCache<SessionId, Prepared> prepared_;
};

}  // namespace isthmus::server
