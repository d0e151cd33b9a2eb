// The editing part of the pipeline: people's decisions about the map.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>
#include <string>

#include "core/clock.h"
#include "server/map/map_writer.h"
#include "server/pipeline.h"
#include "storage/map_store.h"

namespace isthmus::server {

// See Pipeline for the promises. Each looks at one view, with `membership` held so that no session
// goes until the store is written, and waits for the new placement without it. Thread safe.
class MapDecisions {
 public:
  MapDecisions(MapWriter* map, const storage::MapStore* store, const Clock* clock,
               Mutex* membership)
      : map_(map), map_store_(store), clock_(clock), membership_(membership) {}

  absl::StatusOr<DecidedMatch> DecideMatch(const MatchDecision& decision, const Actor& by);
  absl::StatusOr<DecidedLoop> DecideLoop(const LoopDecision& decision, const Actor& by);
  absl::StatusOr<int64_t> PutAnchor(Anchor anchor, const Actor& by);
  absl::StatusOr<int64_t> RemoveAnchor(const SubmapId& submap, const Actor& by);
  absl::Status SetDatum(std::optional<Datum> datum, const Actor& by);
  absl::StatusOr<int64_t> UndoRevision(int64_t revision, const std::string& note, const Actor& by);

 private:
  // The rejections of what the revision came from.
  ManualEdit RejectCauses(const RevisionInfo& revision, const std::string& note) const;
  int64_t RevisionOncePlaced() const;

  MapWriter* const map_;
  const storage::MapStore* const map_store_;
  const Clock* const clock_;
  Mutex* const membership_;
};

}  // namespace isthmus::server
