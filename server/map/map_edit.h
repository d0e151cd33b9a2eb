// An edit, which turns one view of the map into the next.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/map/map_view.h"
#include "storage/map_store.h"

namespace isthmus::server {

// The changes since the map was placed last: the causes of the next revision.
struct Changes {
  std::vector<std::string> causes;  // For a person; the first few.
  std::vector<SessionPair> matches;
  std::vector<uint64_t> loops;
};

// The result of placing the state at `version`.
struct PlacedMap {
  uint64_t version = 0;                         // MapView::graph_version.
  std::shared_ptr<const MapRevision> revision;  // Null where nothing moved: the last one stands.
  std::vector<SessionPair> tree;
  placement::EdgeStatus edge_status;
};

// One kind of change, or several at once.
struct MapEdit {
  // Sessions without which the edit is void: it was worked out from an older view.
  std::vector<SessionId> rests_on = {};
  storage::WriteBatch batch = {};  // Its revision is not looked at: that is `placed`.
  std::optional<SessionId> removed_session = {};
  Changes changes = {};  // With causes: the map is to be placed anew.
  std::optional<PlacedMap> placed = {};
  std::shared_ptr<const ComposedMap> composed = {};
};

// The slow part of an edit, prepared before anybody waits for it.
struct PreparedEdit {
  storage::SubmapInfos infos;  // The batch's submaps.
  // Null: the effective matches stay as they are.
  std::shared_ptr<const std::vector<Match>> effective = {};
};

bool IsVoid(const MapEdit& edit, const MapView& view);

// True if the effective matches have to be worked out anew: with matches, manual decisions and the
// sessions that have submaps.
bool ChangesMatches(const MapEdit& edit, const MapView& view);

// Goes round all cycles of matches, and settles the matches that sessions settle together.
std::shared_ptr<const std::vector<Match>> EffectiveMatches(const MapView& view);

// Takes a pass over the batch's points and, where needed, goes round all cycles of matches.
PreparedEdit Prepare(const MapEdit& edit, const MapView& view);

// The next view; copies what changes and shares the rest. No side effects. `prepared` may come from
// an earlier view as long as no edit since then changed matches.
std::shared_ptr<const MapView> Apply(const MapView& view, const MapEdit& edit,
                                     const PreparedEdit& prepared);
std::shared_ptr<const MapView> Apply(const MapView& view, const MapEdit& edit);

}  // namespace isthmus::server
