// The part of the composer's state that makes tiles.
#include <algorithm>
#include <limits>
#include <utility>

#include "core/content_hash.h"
#include "server/composition/composer_state.h"
#include "server/composition/limits.h"

namespace isthmus::composition {
namespace {

uint32_t StampOf(const SubmapFingerprint& submap) {
  constexpr int64_t kSecond = 1'000'000'000;
  return static_cast<uint32_t>(
      std::clamp<int64_t>(submap.last_stamp_ns / kSecond, 0, std::numeric_limits<uint32_t>::max()));
}

// By robots' names: numbers are another composer's others.
uint64_t VersionOf(const TileContent& content, const std::vector<RobotId>& robots) {
  ContentHash hash;
  for (const TilePart& part : content.record.parts) {
    hash.AddText(robots[part.robot].value());
    hash.AddBytes(content.points.data() + part.begin,
                  (part.end() - part.begin) * sizeof(TilePoint));
  }
  return hash.value();
}

}  // namespace

// Drops tiles that the map has no room for, and marks those that it has room for again.
void Composer::State::KeepToLimit() {
  if (!limit.Update()) return;
  limit.ForEach([this](const TileKey& key) {
    if (!limit.Stays(key)) {
      present.tiles.erase(key);
      gone.tiles.erase(key);
      dirty.erase(key);
    } else if (!present.tiles.contains(key) && !gone.tiles.contains(key)) {
      dirty.insert(key);
    }
  });
}

absl::StatusOr<std::map<TileKey, std::vector<OnTile>>> Composer::State::WhatIsOnDirty() const {
  std::map<TileKey, std::vector<OnTile>> on_tile;
  for (const TileKey& key : dirty) on_tile[key];
  for (const auto& [id, composed] : submaps) {
    if (!KeepsOn()) return Stopped();
    for (size_t i = 0; i < composed.tiles.size(); ++i) {
      const auto it = on_tile.find(composed.tiles[i]);
      if (it != on_tile.end()) it->second.push_back({&composed, i});
    }
  }
  return on_tile;
}

absl::StatusOr<TileContent> Composer::State::MakeTile(const std::vector<OnTile>& sources,
                                                      bool of_gone, bool* has_others) {
  *has_others = false;
  for (const OnTile& source : sources) {
    if (!KeepsOn()) {
      builder.TakeContent();
      return Stopped();
    }
    const Composed& composed = *source.composed;
    at_hand = composed.id;
    const auto piece = thinned.PieceOf(composed.id, source.tile);
    if (!piece.ok()) {
      builder.TakeContent();                // Points added so far are of no use.
      ForgetSubmap(SubmapId(composed.id));  // To be read and thinned again.
      return piece.status();
    }
    builder.Add({piece->points, piece->runs, composed.T_map_submap, composed.robot,
                 StampOf(composed.fingerprint), of_gone});
    *has_others = *has_others || builder.left_out();
  }
  at_hand.reset();
  TileContent content = builder.TakeContent();
  content.record.version = VersionOf(content, robots);
  return content;
}

// One that is as it was stays, so that its revision tells when it became so.
void Composer::State::PutTile(const TileKey& key, TileContent content, int64_t revision,
                              MadeMap* into) {
  if (content.points.empty()) {
    into->tiles.erase(key);
    return;
  }
  TilePtr& tile = into->tiles[key];
  const bool as_before = tile != nullptr && tile->record().version == content.record.version;
  content.record.revision = as_before ? tile->record().revision : revision;
  content.record.x = key.x;
  content.record.y = key.y;
  tile = cache->Add(std::move(content));
}

absl::Status Composer::State::RemakeTile(const TileKey& key, std::vector<OnTile> sources,
                                         int64_t revision) {
  std::stable_sort(sources.begin(), sources.end(), [&](const OnTile& l, const OnTile& r) {
    return robots[l.composed->robot] < robots[r.composed->robot];
  });
  bool has_gone = false, has_others = false;
  absl::StatusOr<TileContent> content = MakeTile(sources, false, &has_gone);
  absl::StatusOr<TileContent> dropped = TileContent();
  if (content.ok() && has_gone) dropped = MakeTile(sources, true, &has_others);
  for (const auto* made : {&content, &dropped}) {
    if (!made->ok()) return made->status();
  }
  PutTile(key, *std::move(content), revision, &present);
  PutTile(key, *std::move(dropped), revision, &gone);
  return absl::OkStatus();
}

// Asks all submaps about each other's points; tiles on which some leave or come back are dirty.
absl::Status Composer::State::LookThrough(const SubmapReader& reader) {
  if (!visibility_filter) return absl::OkStatus();
  const auto on_change = [this](const SubmapId& id, const std::vector<size_t>& changed) {
    const std::vector<TileKey>& keys = submaps.at(id).tiles;
    for (const size_t tile : changed) dirty.insert(keys[tile]);
  };
  const auto keep_on = [this] { return KeepsOn(); };
  const absl::Status status =
      visibility_filter->Update(reader, &thinned, on_change, keep_on, &at_hand);
  // To be read and thinned again.
  if (absl::IsDataLoss(status)) ForgetSubmap(SubmapId(*at_hand));
  at_hand.reset();
  return status;
}

absl::Status Composer::State::RemakeTiles(int64_t revision) {
  const double all = static_cast<double>(dirty.size());
  auto on_dirty = WhatIsOnDirty();
  if (!on_dirty.ok()) return on_dirty.status();
  for (auto& [key, sources] : *on_dirty) {
    absl::Status status = RemakeTile(key, std::move(sources), revision);
    if (!status.ok()) return status;
    dirty.erase(key);
    ++last_tiles_remade;
    if (status = cache->KeepToMemory(); !status.ok()) return status;
    share = 1 - (1 - kReadingShare) * static_cast<double>(dirty.size()) / all;
    if (!KeepsOn()) return Stopped();
  }
  return absl::OkStatus();
}

Composer::LeftOut Composer::State::CountLeftOut() const {
  LeftOut all;
  uint64_t largest = 0;
  for (const auto& [id, composed] : submaps) {
    uint64_t points = composed.left_out;
    for (size_t i = 0; i < composed.tiles.size() && !limit.has_room_for_all(); ++i) {
      if (!limit.Stays(composed.tiles[i])) points += composed.point_count[i];
    }
    all.points += points;
    if (points <= largest) continue;
    largest = points;
    all.most = id;
  }
  return all;
}

std::vector<TiledMap::Component> Composer::State::ComponentsIn(
    MadeMap* made, const std::map<uint32_t, uint32_t>& frames, int64_t revision) {
  constexpr int32_t kLowest = std::numeric_limits<int32_t>::min();
  std::vector<TiledMap::Component> components(frames.empty() ? 0 : frames.rbegin()->first + 1);
  std::map<uint32_t, std::shared_ptr<const TilePyramid>> before = std::exchange(made->pyramids, {});
  for (const auto& [number, frame] : frames) {
    TiledMap::Component& component = components[number];
    for (auto it = made->tiles.lower_bound({frame, kLowest, kLowest});
         it != made->tiles.end() && it->first.frame == frame; ++it) {
      const TilePtr& tile = it->second;
      component.tiles.push_back(tile);
      component.point_count += tile->point_count();
      component.bounds.Extend(tile->bounds());
    }
    component.pyramid =
        std::make_shared<const TilePyramid>(component.tiles, revision, before[frame].get());
    made->pyramids[frame] = component.pyramid;
  }
  return components;
}

// `frames` of components.
std::shared_ptr<const TiledMap> Composer::State::MapOf(int64_t revision,
                                                       const std::map<uint32_t, uint32_t>& frames,
                                                       TiledMap::Submaps about) {
  const TiledMap::Scale scale{options.voxel_m, layout.voxels()};
  std::shared_ptr<const TiledMap> dropped;
  if (visibility_filter) {
    dropped =
        std::make_shared<TiledMap>(revision, RobotsInMap(), ComponentsIn(&gone, frames, revision),
                                   scale, made_tiles, TiledMap::Submaps(), nullptr);
  }
  return std::make_shared<TiledMap>(revision, RobotsInMap(),
                                    ComponentsIn(&present, frames, revision), scale, made_tiles,
                                    std::move(about), std::move(dropped));
}

}  // namespace isthmus::composition
