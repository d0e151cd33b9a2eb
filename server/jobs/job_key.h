// The names of pieces of matching's work: by them the queue, the journal and the scheduler mean the
// same piece.
#pragma once

#include <absl/strings/string_view.h>

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/ids.h"
#include "storage/map_records.h"

namespace isthmus::server {

// The match of two sessions.
struct MatchKey {
  storage::SessionPair pair;
  friend auto operator<=>(const MatchKey&, const MatchKey&) = default;
};

// The comparison of a session's plan with those of others.
struct IndexKey {
  SessionId session;
  friend auto operator<=>(const IndexKey&, const IndexKey&) = default;
};

// The search for loops of a submap.
struct LoopKey {
  SubmapId submap;
  friend auto operator<=>(const LoopKey&, const LoopKey&) = default;
};

// The shape that its loops give a session.
struct ShapeKey {
  SessionId session;
  friend auto operator<=>(const ShapeKey&, const ShapeKey&) = default;
};

// The count of submaps that were seen again.
struct RevisitsKey {
  friend auto operator<=>(const RevisitsKey&, const RevisitsKey&) = default;
};

using JobKey = std::variant<MatchKey, IndexKey, LoopKey, ShapeKey, RevisitsKey>;

// One line for programs, "match alice-1 bob-1", "index alice-1", "loops alice-1/3",
// "shape alice-1", "revisits".
std::string ToText(const JobKey& key);
// The key of such a line; nothing for any other text.
std::optional<JobKey> ParseJobKey(absl::string_view text);
// The same for people: "the match of alice-1 and bob-1".
std::string Describe(const JobKey& key);

// The sessions that it is about.
std::vector<SessionId> SessionsOf(const JobKey& key);

}  // namespace isthmus::server
