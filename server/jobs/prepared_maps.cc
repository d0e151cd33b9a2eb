#include "server/jobs/prepared_maps.h"

#include "server/jobs/limits.h"

namespace isthmus::server {

PreparedMaps::Prepared PreparedMaps::Get(const ShapedMap& shaped) {
  const SessionMap& map = shaped.map;
  Prepared before;
  if (const Prepared* held = prepared_.Use(map.session)) {
    // Submaps are immutable and shared, so the same ones are the same map.
    if ((*held)->session_map().submaps == map.submaps && (*held)->shape() == shaped.shape) {
      return *held;
    }
    before = *held;
    prepared_.Erase(map.session);
  }
  using matching::PreparedMap;
  const Prepared made =
      before ? std::make_shared<const PreparedMap>(map, *before, source_, shaped.shape)
             : std::make_shared<const PreparedMap>(map, source_, shaped.shape);
  prepared_.Put(map.session, made, made->bytes());
  while (prepared_.size() > 2 &&
         (prepared_.size() > kMaxPreparedMaps || prepared_.weight() > max_bytes_)) {
    prepared_.DropOldest();
  }
  return made;
}

}  // namespace isthmus::server
