#include "server/composition/tiles/tiled_map.h"

#include <absl/container/flat_hash_set.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/map/region_extent.h"
#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {
namespace {

const TiledMap::Component& NoComponent() {
  static const TiledMap::Component none;
  return none;
}

// The choice of a region's points, without regard to robots.
class Selection {
 public:
  explicit Selection(const Region& region)
      : region_(region),
        extent_(region),
        is_of_any_time_(region_.seen_from == 0 &&
                        region.seen_to == std::numeric_limits<uint32_t>::max()) {}

  bool Touches(const Box& bounds) const { return extent_.MayTouch(bounds); }
  bool ContainsAll(const Box& bounds) const {
    return is_of_any_time_ && region_.classes.has_all() && !region_.keep &&
           extent_.ContainsAll(bounds);
  }
  bool Contains(const TilePoint& point, uint32_t robot) const {
    if (point.stamp < region_.seen_from || point.stamp > region_.seen_to) return false;
    if (!region_.classes.Has(point.label)) return false;
    if (!extent_.Contains(Eigen::Vector3d(point.x, point.y, point.z))) return false;
    return !region_.keep || region_.keep({point.x, point.y, point.z, point.intensity, robot,
                                          point.label, point.stamp});
  }

 private:
  const Region& region_;
  const RegionExtent extent_;
  const bool is_of_any_time_;
};

// Lets one point per voxel of a resolution pass, and knows which points need not be looked at.
//
// Where the voxels are whole blocks of the map's own, the points of a coarse level of detail say
// which of them have points: all others would be thinned away.
class Thinning {
 public:
  Thinning(double resolution_m, const TiledMap::Scale& scale)
      : own_grid_(scale.voxel_m), tile_voxels_(scale.tile_voxels) {
    if (!(resolution_m > 0)) return;
    grid_.emplace(resolution_m);
    const double ratio = resolution_m / scale.voxel_m, whole = std::round(ratio);
    // A share of a voxel that nobody means by a resolution, but that decimals make.
    constexpr double kTolerance = 1e-6;
    if (whole < 1 || whole > kMaxBlock || std::abs(ratio - whole) > kTolerance * whole) return;
    block_ = static_cast<int32_t>(whole);
    level_ = static_cast<uint32_t>(std::countr_zero(static_cast<uint32_t>(block_)));
    level_ = std::min(level_, kDetailLevels - 1);
  }

  // The level of detail that is enough of a tile that lies in the region as a whole; a part of a
  // tile may have points in a voxel of which the coarse level has one outside.
  uint32_t level(bool whole_tile) const { return whole_tile ? level_ : 0; }
  // True if all points pass of a tile of which so many parts are read, of this level.
  bool PassesAll(size_t parts, uint32_t level) const {
    return !grid_ || (divides() && parts == 1 && block_ == 1 << level);
  }
  // To be called before each tile.
  void BeginTile(size_t parts, uint32_t level) {
    if (divides()) seen_.clear();  // No voxel lies on two tiles.
    passes_all_ = PassesAll(parts, level);
  }
  bool Passes(const TilePoint& p) {
    if (passes_all_) return true;
    auto voxel = (block_ > 0 ? own_grid_ : *grid_).Find(p.x, p.y, p.z);
    // So fine a grid over so large a map that it has no number for the voxel: nothing to thin.
    if (!voxel) return true;
    if (block_ > 1) voxel = Voxel{Divide(voxel->x), Divide(voxel->y), Divide(voxel->z)};
    return seen_.insert(PackVoxel(*voxel)).second;
  }

 private:
  // The largest block that is counted in the map's own voxels: as many as there are along an axis.
  static constexpr double kMaxBlock = 1 << 20;  // Layout

  bool divides() const { return block_ > 0 && tile_voxels_ % block_ == 0; }
  int32_t Divide(int32_t index) const {  // Rounds down.
    return index >= 0 ? index / block_ : -((-index - 1) / block_) - 1;
  }

  const VoxelGrid own_grid_;
  const int32_t tile_voxels_;
  std::optional<VoxelGrid> grid_;  // None: as composed.
  int32_t block_ = 0;              // Own voxels along an edge of one of the grid; 0: not whole.
  uint32_t level_ = 0;
  bool passes_all_ = false;  // On this tile.
  absl::flat_hash_set<uint64_t> seen_;
};

// Collects points into chunks.
class ChunkWriter {
 public:
  ChunkWriter(size_t chunk, uint64_t skip, const ComposedMap::Emit& emit)
      : chunk_(std::max<size_t>(chunk, 1)), skip_(skip), emit_(emit) {}

  // True if so many points would all be left out; they are then.
  bool Skips(uint64_t points) {
    if (points > skip_) return false;
    skip_ -= points;
    return true;
  }

  // False once the reader has had enough.
  bool Write(const TilePoint& p, uint32_t robot) {
    if (skip_ > 0) return Skips(1);
    buffer_.push_back({p.x, p.y, p.z, p.intensity, robot, p.label, p.stamp});
    return buffer_.size() < chunk_ || Flush();
  }
  bool Flush() {
    const bool more = buffer_.empty() || emit_(buffer_);
    buffer_.clear();
    return more;
  }

 private:
  const size_t chunk_;
  uint64_t skip_;  // More points are left out.
  const ComposedMap::Emit& emit_;
  std::vector<MapPoint> buffer_;
};

}  // namespace

TiledMap::TiledMap(int64_t revision, const std::vector<Robot>& robots,
                   std::vector<Component> components, const Scale& scale,
                   std::shared_ptr<MadeTiles> made, Submaps submaps,
                   std::shared_ptr<const ComposedMap> dropped)
    : revision_(revision),
      submaps_(std::move(submaps)),
      dropped_(std::move(dropped)),
      scale_(scale),
      grid_(scale.voxel_m),
      made_(std::move(made)),
      components_(std::move(components)) {
  for (const Robot& robot : robots) {
    if (index_of_number_.size() <= robot.number) index_of_number_.resize(robot.number + 1);
    index_of_number_[robot.number] = static_cast<uint32_t>(robots_.size());
    robots_.push_back(robot.id);
  }
}

const TiledMap::Component* TiledMap::Find(uint32_t component) const {
  return component < components_.size() ? &components_[component] : nullptr;
}

std::optional<uint32_t> TiledMap::component_of(const SessionId& session) const {
  const auto it = submaps_.places.find(session);
  return it == submaps_.places.end() ? std::nullopt : std::optional<uint32_t>(it->second);
}

uint64_t TiledMap::point_count(uint32_t component) const {
  return component < components_.size() ? components_[component].point_count : 0;
}

Box TiledMap::bounds(uint32_t component) const {
  return component < components_.size() ? components_[component].bounds : Box();
}

const std::vector<TilePtr>& TiledMap::tiles(uint32_t component) const {
  return component < components_.size() ? components_[component].tiles : NoComponent().tiles;
}

size_t TiledMap::PartsOf(const Tile& tile, int robot) const {
  if (robot < 0) return tile.parts().size();
  return static_cast<size_t>(
      std::count_if(tile.parts().begin(), tile.parts().end(), [&](const TilePart& part) {
        return index_of_number_[part.robot] == static_cast<uint32_t>(robot);
      }));
}

absl::Status TiledMap::Read(const Region& region, size_t chunk, const Emit& emit) const {
  const Selection selection(region);
  Thinning thinning(region.resolution_m, scale_);
  ChunkWriter writer(chunk, region.skip, emit);
  for (const TilePtr& tile : tiles(region.component)) {
    if (region.keep_on && !region.keep_on()) return absl::OkStatus();
    if (!selection.Touches(tile->bounds())) continue;
    const bool whole = selection.ContainsAll(tile->bounds());
    const size_t parts = PartsOf(*tile, region.robot);
    if (parts == 0) continue;
    const bool is_counted = whole && region.robot < 0 && !(region.resolution_m > 0);
    if (is_counted && writer.Skips(tile->point_count())) continue;
    const uint32_t level = thinning.level(whole);
    thinning.BeginTile(parts, level);
    const absl::StatusOr<TilePoints> read = tile->Points(level);
    if (!read.ok()) return read.status();
    for (size_t part = 0; part < read->ranges.size(); ++part) {
      const uint32_t robot = index_of_number_[tile->parts()[part].robot];
      if (region.robot >= 0 && robot != static_cast<uint32_t>(region.robot)) continue;
      const auto [begin, end] = read->ranges[part];
      for (uint32_t i = begin; i < end; ++i) {
        const TilePoint& p = (*read->points)[i];
        if (!whole && !selection.Contains(p, robot)) continue;
        if (thinning.Passes(p) && !writer.Write(p, robot)) return absl::OkStatus();
      }
    }
  }
  writer.Flush();
  return absl::OkStatus();
}

PointBounds TiledMap::BoundsOf(const Region& region) const {
  const Selection selection(region);
  const Thinning thinning(region.resolution_m, scale_);
  PointBounds bounds{0, 0};
  for (const TilePtr& tile : tiles(region.component)) {
    if (!selection.Touches(tile->bounds())) continue;
    const bool whole = selection.ContainsAll(tile->bounds());
    const uint32_t level = thinning.level(whole);
    uint64_t points = 0;
    for (const TilePart& part : tile->parts()) {
      const uint32_t robot = index_of_number_[part.robot];
      if (region.robot >= 0 && robot != static_cast<uint32_t>(region.robot)) continue;
      points += part.EndOf(level) - part.begin;
    }
    bounds.most += points;
    if (whole && thinning.PassesAll(PartsOf(*tile, region.robot), level)) bounds.least += points;
  }
  return bounds;
}

}  // namespace isthmus::composition
