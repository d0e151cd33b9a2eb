// Prepared submaps, made once and kept in the store beside the submaps themselves.
#pragma once

#include <memory>

#include "core/submap.h"
#include "server/matching/prepared_submap.h"
#include "storage/map_store.h"

namespace isthmus::server {

// Thread safe, as the store is.
class PreparedStore {
 public:
  explicit PreparedStore(storage::MapStore* store) : store_(store) {}

  // What was kept, or made and kept. What is damaged or of another version is made anew; what
  // cannot be kept is made again after the next restart. Never null.
  std::shared_ptr<const matching::PreparedSubmap> Get(
      const std::shared_ptr<const Submap>& submap) const;

 private:
  std::shared_ptr<const matching::PreparedSubmap> Find(
      const std::shared_ptr<const Submap>& submap) const;
  void Keep(const matching::PreparedSubmap& prepared) const;

  storage::MapStore* const store_;
};

}  // namespace isthmus::server
