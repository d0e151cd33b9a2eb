// The decisions that people make about the map.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <optional>
#include <string>

#include "core/map/anchor.h"
#include "core/map/datum.h"
#include "core/records/event.h"
#include "core/records/map_edits.h"

namespace isthmus::server {

// Thread safe. All are durable on return, with the map placed anew; those that return a number
// return the revision after that. A decision is made `by` somebody, for the event log.
class Decisions {
 public:
  virtual ~Decisions() = default;

  // Holds until another decision on the pair, against all that is computed. NotFound for an unknown
  // robot or session, InvalidArgument for a pair of one session, a transform that is not finite or
  // too long a note, FailedPrecondition to accept where nothing was found.
  virtual absl::StatusOr<DecidedMatch> DecideMatch(const MatchDecision& decision,
                                                   const Actor& by = Actor()) = 0;
  // NotFound for an unknown loop closure, InvalidArgument for too long a note.
  virtual absl::StatusOr<DecidedLoop> DecideLoop(const LoopDecision& decision,
                                                 const Actor& by = Actor()) = 0;

  // Gives a submap its place, or another one. NotFound for a submap that is not in the map,
  // InvalidArgument for numbers that are not finite, beyond kMaxAnchorM or no positive sigma.
  virtual absl::StatusOr<int64_t> PutAnchor(Anchor anchor, const Actor& by = Actor()) = 0;
  // NotFound when the submap has none.
  virtual absl::StatusOr<int64_t> RemoveAnchor(const SubmapId& submap,
                                               const Actor& by = Actor()) = 0;

  // Moves nothing that is placed. Absent: there is none any more. InvalidArgument as CheckDatum.
  virtual absl::Status SetDatum(std::optional<Datum> datum, const Actor& by = Actor()) = 0;

  // Rejects, by hand, the accepted matches and loop closures that the revision came of; a transform
  // that was given by hand is withdrawn, so that the computed one counts again. NotFound for one
  // that is not kept; FailedPrecondition when nothing that made it is accepted: a revision that new
  // submaps or an anchor made cannot be undone so.
  virtual absl::StatusOr<int64_t> UndoRevision(int64_t revision, const std::string& note,
                                               const Actor& by = Actor()) = 0;
};

}  // namespace isthmus::server
