// The editing part of the pipeline: people's decisions about the map.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>
#include <string>

#include "server/decisions.h"
#include "server/map/map_writer.h"
#include "server/pipeline/pipeline_parts.h"

namespace isthmus::server {

// See Decisions for the promises. Each looks at one view, with `membership` held so that no session
// goes until the store is written, and waits for the new placement without it. Thread safe.
class MapDecisions : public Decisions {
 public:
  // `parts` must outlive it.
  explicit MapDecisions(PipelineParts* parts) : parts_(*parts) {}

  absl::StatusOr<DecidedMatch> DecideMatch(const MatchDecision& decision, const Actor& by) override;
  absl::StatusOr<DecidedLoop> DecideLoop(const LoopDecision& decision, const Actor& by) override;
  absl::StatusOr<int64_t> PutAnchor(Anchor anchor, const Actor& by) override;
  absl::StatusOr<int64_t> RemoveAnchor(const SubmapId& submap, const Actor& by) override;
  absl::Status SetDatum(std::optional<Datum> datum, const Actor& by) override;
  absl::StatusOr<int64_t> UndoRevision(int64_t revision, const std::string& note,
                                       const Actor& by) override;

 private:
  // The rejections of what the revision came from.
  ManualEdit RejectCauses(const RevisionInfo& revision, const std::string& note) const;
  int64_t RevisionOncePlaced() const;

  PipelineParts& parts_;
};

}  // namespace isthmus::server
