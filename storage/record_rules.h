// Rules that one record must satisfy by itself before any store takes it.
#pragma once

#include <absl/status/status.h>

#include <vector>

#include "core/map/anchor.h"
#include "core/map/loop_closure.h"
#include "core/map/match.h"
#include "core/map/revision.h"
#include "core/map/submap.h"
#include "core/records/event.h"

namespace isthmus::storage {

// Limits of a submap; an encoded one stays within the limits of core/codec/quantized.h.
inline constexpr size_t kMaxSubmapPoints = 4'000'000;
inline constexpr float kMaxCoordinateM = 5000;

// All: InvalidArgument, naming the record and its fault.

// A submap without keyframes, with points of keyframes it does not have or beyond the limits above,
// with poses that are not finite or a covariance that is none.
absl::Status CheckSubmap(const Submap& submap);

// Edges whose pose or information is not finite, or whose information is not symmetric.
absl::Status CheckMatchEdges(const Match& match);

// An id of 0, no edges, its own pair not among them, an edge that does not go from an older submap
// to a newer one, or one of which CheckMatchEdges' words hold.
absl::Status CheckLoop(const LoopClosure& loop);

// Numbers that are not finite or negative where they may not be, no positive sigma, or known
// coordinates beyond kMaxAnchorM.
absl::Status CheckAnchor(const Anchor& anchor);

// Placements that are not finite or come twice; a submap that moves twice, nowhere, to or from a
// frame without a name, or to another frame than that of its session's placement.
absl::Status CheckRevision(const MapRevision& revision, const std::vector<SubmapMove>& moves);

// An event of an unknown kind, or with a string longer than kMaxEventText.
absl::Status CheckEvents(const std::vector<Event>& events);

}  // namespace isthmus::storage
