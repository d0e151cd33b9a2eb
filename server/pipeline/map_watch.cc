#include "server/pipeline/map_watch.h"

#include <absl/container/flat_hash_set.h>

#include <algorithm>
#include <random>
#include <tuple>

#include "server/pipeline/view_reader.h"

namespace isthmus::server {
namespace {

uint64_t RandomRun() {
  std::random_device device;
  return uint64_t{device()} << 32 | device() | 1;  // Zero is that of who knows of none.
}

std::vector<uint32_t> LevelsOf(const ComposedMap& map) {
  std::vector<uint32_t> levels(map.component_count());
  for (uint32_t c = 0; c < levels.size(); ++c) levels[c] = map.tile_levels(c);
  return levels;
}

// The level that is told of a component.
uint32_t ToldLevel(const std::vector<uint32_t>& levels, uint32_t component, uint32_t wanted) {
  const uint32_t has = component < levels.size() ? levels[component] : 0;
  return std::min(wanted, has == 0 ? 0 : has - 1);
}

// The place of a submap, in order of the submaps.
struct Place {
  SubmapId submap;
  uint32_t component;
  const Pose* T_map_submap;
};

std::vector<Place> PlacesOf(const MapView& view) {
  std::vector<Place> places;
  for (const Placement& placement : view.revision->placements) {
    for (const SubmapPose& pose : placement.submaps) {
      places.push_back({{placement.session, pose.index}, placement.component, &pose.T_map_submap});
    }
  }
  return places;
}

bool AreSame(const Pose& a, const Pose& b) {
  return a.translation() == b.translation() && a.rotation().coeffs() == b.rotation().coeffs();
}

// A match as a view shows it.
struct Shown {
  const Match& match;
  const MapView& view;

  SessionPair pair() const { return {match.a, match.b}; }
  bool in_tree() const { return std::binary_search(view.tree->begin(), view.tree->end(), pair()); }
  // When a person said something of it; -1: nobody has.
  int64_t said_ns() const {
    const ManualDecision* said = view.manual_decisions.Find(pair());
    return said == nullptr ? -1 : said->given_ns;
  }
};

bool AreSame(const Shown& a, const Shown& b) {
  const auto figures = [](const Shown& shown) {
    const Match& match = shown.match;
    return std::tuple(match.state, match.reason, match.computed_ns, match.confidence, match.cycle_m,
                      match.cycle_deg, shown.in_tree(), shown.said_ns());
  };
  return figures(a) == figures(b) && AreSame(a.match.T_a_b, b.match.T_a_b) &&
         a.match.detail == b.match.detail;
}

// Without what carries it.
MatchEdge Told(const Match& match, const MapView& view) {
  MatchEdge edge = ViewReader::Describe(match, view);
  edge.match.edges.clear();
  edge.match.rivals.clear();
  edge.match.asked.clear();
  return edge;
}

// Puts down the keys of what is in one of two ordered lists alone, or differs.
template <typename Item, typename KeyOf, typename Same, typename Key>
void FindChanged(const std::vector<Item>& before, const std::vector<Item>& now, const KeyOf& key_of,
                 const Same& same, std::vector<Key>* changed) {
  auto b = before.begin();
  auto n = now.begin();
  while (b != before.end() || n != now.end()) {
    if (n == now.end() || (b != before.end() && key_of(*b) < key_of(*n))) {
      changed->push_back(key_of(*b++));
    } else if (b == before.end() || key_of(*n) < key_of(*b)) {
      changed->push_back(key_of(*n++));
    } else {
      if (!same(*b, *n)) changed->push_back(key_of(*n));
      ++b;
      ++n;
    }
  }
}

template <typename Key>
void Append(const std::vector<Key>& more, std::vector<Key>* all) {
  all->insert(all->end(), more.begin(), more.end());
}

template <typename Key>
void MakeUnique(std::vector<Key>* keys) {
  std::sort(keys->begin(), keys->end());
  keys->erase(std::unique(keys->begin(), keys->end()), keys->end());
}

}  // namespace

MapWatch::MapWatch(size_t max_logged) : max_logged_(max_logged), run_(RandomRun()) {}

MapWatch::StatePtr MapWatch::Describe(std::shared_ptr<const MapView> view,
                                      std::shared_ptr<const ComposedMap> map) {
  auto state = std::make_shared<State>();
  state->view = std::move(view);
  state->map = std::move(map);
  state->levels = LevelsOf(*state->map);
  for (uint32_t c = 0; c < state->levels.size(); ++c)
    Append(state->map->Tiles(c, 0), &state->tiles);
  return state;
}

MapWatch::Change MapWatch::Compare(const State& before, const State& now) {
  Change change;
  change.revision = now.map->revision();
  change.levels_before = before.levels;
  FindChanged(
      before.tiles, now.tiles, [](const TileInfo& tile) { return tile.id; },
      [](const TileInfo& b, const TileInfo& n) { return b.version == n.version; }, &change.tiles);
  FindChanged(
      PlacesOf(*before.view), PlacesOf(*now.view), [](const Place& place) { return place.submap; },
      [](const Place& b, const Place& n) {
        return b.component == n.component && AreSame(*b.T_map_submap, *n.T_map_submap);
      },
      &change.submaps);
  FindChanged(
      *before.view->effective, *now.view->effective,
      [](const Match& match) { return SessionPair(match.a, match.b); },
      [&](const Match& b, const Match& n) {
        return AreSame(Shown{b, *before.view}, Shown{n, *now.view});
      },
      &change.matches);
  return change;
}

void MapWatch::Activate() {
  if (is_active_) return;
  is_active_ = true;
  if (map_ != nullptr) state_ = Describe(std::move(view_), map_);
  if (map_ != nullptr) known_from_ = map_->revision();
  map_ = nullptr;
}

void MapWatch::Log(Change change) {
  logged_ += change.size();
  changes_.push_back(std::move(change));
  while (logged_ > max_logged_) {
    logged_ -= changes_.front().size();
    known_from_ = changes_.front().revision;
    changes_.pop_front();
  }
}

void MapWatch::Note(const MapView& composed_of, std::shared_ptr<const ComposedMap> map) {
  auto view = std::make_shared<MapView>(composed_of);
  view->map = nullptr;  // An older one, whose tiles would stay.
  StatePtr before;
  {
    MutexLock lock(&mutex_);
    if (!is_active_) {
      view_ = std::move(view);
      map_ = std::move(map);
      return;
    }
    before = state_;
  }
  const StatePtr now = Describe(std::move(view), std::move(map));
  std::optional<Change> change;
  if (before != nullptr) change = Compare(*before, *now);
  {
    MutexLock lock(&mutex_);
    state_ = now;
    if (before != nullptr && now->map->revision() <= before->map->revision()) {
      // Nobody can say by its number which of the two is known.
      run_ = RandomRun();
      changes_.clear();
      logged_ = 0;
      known_from_ = now->map->revision();
    } else if (change) {
      Log(*std::move(change));
    } else {
      known_from_ = now->map->revision();
    }
  }
  wakes_.Tell();
}

MapStep MapWatch::Everything(const State& state, uint32_t level) {
  MapStep step;
  step.restart = true;
  for (uint32_t c = 0; c < state.levels.size(); ++c) {
    Append(state.map->Tiles(c, ToldLevel(state.levels, c, level)), &step.tiles);
  }
  for (const Place& place : PlacesOf(*state.view)) {
    const SessionView* session = state.view->Find(place.submap.session);
    step.submaps.push_back({place.submap, session == nullptr ? RobotId() : session->record.robot,
                            place.component, *place.T_map_submap});
  }
  for (const Match& match : *state.view->effective) {
    step.matches.push_back(Told(match, *state.view));
  }
  return step;
}

void MapWatch::AddTiles(const State& state, const Change& all, uint32_t level, MapStep* step) {
  // For each changed tile of level 0: the tile that is told of it, before and now.
  absl::flat_hash_set<std::tuple<uint32_t, uint32_t, int32_t, int32_t>> told;
  std::vector<bool> components(state.levels.size(), false);
  const auto tell = [&](const TileId& tile, uint32_t at_level) {
    told.emplace(tile.component, at_level, tile.x >> at_level, tile.y >> at_level);
  };
  for (const TileId& tile : all.tiles) {
    tell(tile, ToldLevel(all.levels_before, tile.component, level));
    if (tile.component >= components.size()) continue;
    tell(tile, ToldLevel(state.levels, tile.component, level));
    components[tile.component] = true;
  }
  for (uint32_t c = 0; c < components.size(); ++c) {
    if (!components[c]) continue;
    for (TileInfo& tile : state.map->Tiles(c, ToldLevel(state.levels, c, level))) {
      if (told.erase({c, tile.id.level, tile.id.x, tile.id.y}) == 0) continue;
      step->tiles.push_back(std::move(tile));
    }
  }
  for (const auto& [component, at_level, x, y] : told) {
    step->removed_tiles.push_back({component, at_level, x, y});
  }
  std::sort(step->removed_tiles.begin(), step->removed_tiles.end());
}

MapStep MapWatch::Changed(const State& state, const Change& all, uint32_t level) {
  MapStep step;
  AddTiles(state, all, level, &step);
  const std::vector<Place> places = PlacesOf(*state.view);
  auto place = places.begin();
  for (const SubmapId& id : all.submaps) {
    while (place != places.end() && place->submap < id) ++place;
    SubmapPlace& told = step.submaps.emplace_back();
    told.submap = id;
    const SessionView* session = state.view->Find(id.session);
    if (session != nullptr) told.robot = session->record.robot;
    if (place == places.end() || place->submap != id) continue;
    told.component = place->component;
    told.T_map_submap = *place->T_map_submap;
  }
  for (const SessionPair& pair : all.matches) {
    if (const Match* match = state.view->EffectiveMatch(pair)) {
      step.matches.push_back(Told(*match, *state.view));
    } else {
      step.removed_matches.push_back(pair);
    }
  }
  return step;
}

std::optional<MapStep> MapWatch::Since(const MapMark& known, uint32_t level) {
  StatePtr state;
  uint64_t run = 0;
  std::optional<Change> all;  // Nothing: it is to begin anew.
  {
    MutexLock lock(&mutex_);
    Activate();
    state = state_;
    run = run_;
    if (state == nullptr) return std::nullopt;
    const int64_t newest = state->map->revision();
    if (known.run == run_ && known.revision >= known_from_ && known.revision <= newest) {
      all.emplace();
      all->levels_before = state->levels;
      for (auto it = changes_.rbegin(); it != changes_.rend(); ++it) {
        if (it->revision <= known.revision) break;
        all->levels_before = it->levels_before;
        Append(it->tiles, &all->tiles);
        Append(it->submaps, &all->submaps);
        Append(it->matches, &all->matches);
      }
    }
  }
  if (all) {
    MakeUnique(&all->tiles);
    MakeUnique(&all->submaps);
    MakeUnique(&all->matches);
    // Tiles of another level take the places of all that a component had.
    for (uint32_t c = 0; c < std::min(state->levels.size(), all->levels_before.size()); ++c) {
      if (ToldLevel(state->levels, c, level) != ToldLevel(all->levels_before, c, level)) {
        all.reset();
        break;
      }
    }
  }
  MapStep step = all ? Changed(*state, *all, level) : Everything(*state, level);
  step.mark = {run, state->map->revision()};
  step.tile_m = state->map->tile_m();
  return step;
}

}  // namespace isthmus::server
