// Prepared submaps, made once and kept in the store beside the submaps themselves.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <stop_token>
#include <string>

#include "core/map/submap.h"
#include "server/map/submap_cache.h"
#include "server/matching/prepared/prepared_submap.h"
#include "storage/map_store.h"

namespace isthmus::server {

// Thread safe, as the store is.
class PreparedStore {
 public:
  PreparedStore(storage::MapStore* store, SubmapCache* submaps)
      : store_(store), submaps_(submaps) {}

  // The prepared submap, from the store or made and stored, the same either way. A record that is
  // damaged or of another version is made anew; one that cannot be kept is made again after the
  // next restart. For a submap that is damaged, or gone by now, it has no surface. Cancelled once
  // `stop` is requested; other errors are the store's.
  absl::StatusOr<std::shared_ptr<const matching::PreparedSubmap>> Get(
      const std::shared_ptr<const Submap>& outline, const std::stop_token& stop) const;

 private:
  std::shared_ptr<const matching::PreparedSubmap> Find(
      const std::shared_ptr<const Submap>& outline) const;
  void StorePrepared(const SubmapId& submap, const std::string& bytes) const;

  storage::MapStore* const store_;
  SubmapCache* const submaps_;
};

}  // namespace isthmus::server
