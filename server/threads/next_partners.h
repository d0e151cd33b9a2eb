// The choice of partners: the pair of sessions to search next, once there are too many to search
// every one.
#pragma once

#include <optional>

#include "server/map/map_view.h"
#include "server/threads/matching_ledger.h"

namespace isthmus::server {

// True for segments of one session: they are searched before any others.
bool AreSegments(const SessionView& a, const SessionView& b);

// The likeliest pair that was never tried: what the server before was at, and what is known to be
// near each other first; then, as long as either has not had its partners, what the index
// promises most and is not joined yet, of those at hand where there are any; what is joined and
// lies near each other; and what else the index promises.
std::optional<SessionPair> NextPartners(const MapView& view, const MatchingLedger& ledger);

}  // namespace isthmus::server
