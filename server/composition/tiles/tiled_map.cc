#include "server/composition/tiles/tiled_map.h"

#include <absl/container/flat_hash_set.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {
namespace {

const TiledMap::Component& NoComponent() {
  static const TiledMap::Component none;
  return none;
}

// The geometric part of a region.
class Shape {
 public:
  explicit Shape(const Region& region) : region_(region), has_box_(!region.box.empty()) {}

  bool Touches(const Box& bounds) const {
    if (has_box_ && !region_.box.Intersects(bounds)) return false;
    if (!region_.has_sphere) return true;
    const Eigen::Vector3d nearest = region_.center.cwiseMax(bounds.min).cwiseMin(bounds.max);
    return InSphere(nearest);
  }
  bool ContainsAll(const Box& bounds) const {
    if (has_box_ && !(region_.box.Contains(bounds.min) && region_.box.Contains(bounds.max))) {
      return false;
    }
    if (!region_.has_sphere) return true;
    const Eigen::Vector3d farthest =
        (region_.center - bounds.min).cwiseAbs().cwiseMax((bounds.max - region_.center).cwiseAbs());
    return InSphere(region_.center + farthest);
  }
  bool Contains(const Eigen::Vector3d& p) const {
    return (!has_box_ || region_.box.Contains(p)) && (!region_.has_sphere || InSphere(p));
  }

 private:
  bool InSphere(const Eigen::Vector3d& p) const {
    const double r = region_.radius_m;
    return r >= 0 && (p - region_.center).squaredNorm() <= r * r;
  }

  const Region& region_;
  const bool has_box_;
};

// Lets one point per voxel pass.
class Thinning {
 public:
  explicit Thinning(double resolution_m) {
    if (resolution_m > 0) grid_.emplace(resolution_m);
  }
  bool Passes(const Point& p) {
    if (!grid_) return true;
    const auto voxel = grid_->Find(p.x, p.y, p.z);
    // So fine a grid over so large a map that it has no number for the voxel: nothing to thin.
    return !voxel || seen_.insert(PackVoxel(*voxel)).second;
  }

 private:
  std::optional<VoxelGrid> grid_;
  absl::flat_hash_set<uint64_t> seen_;
};

// Collects points into chunks.
class ChunkWriter {
 public:
  ChunkWriter(size_t chunk, const ComposedMap::Emit& emit)
      : chunk_(std::max<size_t>(chunk, 1)), emit_(emit) {}

  // False once the reader has had enough.
  bool Write(const Point& p, uint32_t robot) {
    buffer_.push_back({p.x, p.y, p.z, p.intensity, robot});
    return buffer_.size() < chunk_ || Flush();
  }
  bool Flush() {
    const bool more = buffer_.empty() || emit_(buffer_);
    buffer_.clear();
    return more;
  }

 private:
  const size_t chunk_;
  const ComposedMap::Emit& emit_;
  std::vector<MapPoint> buffer_;
};

}  // namespace

TiledMap::TiledMap(int64_t revision, const std::vector<Robot>& robots,
                   std::vector<Component> components, uint64_t missing_submaps)
    : revision_(revision), missing_submaps_(missing_submaps), components_(std::move(components)) {
  for (const Robot& robot : robots) {
    if (index_of_number_.size() <= robot.number) index_of_number_.resize(robot.number + 1);
    index_of_number_[robot.number] = static_cast<uint32_t>(robots_.size());
    robots_.push_back(robot.id);
  }
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

bool TiledMap::HasPointsOf(const Tile& tile, int robot) const {
  if (robot < 0) return true;
  return std::any_of(tile.parts().begin(), tile.parts().end(), [&](const TilePart& part) {
    return index_of_number_[part.robot] == static_cast<uint32_t>(robot);
  });
}

absl::Status TiledMap::Read(const Region& region, size_t chunk, const Emit& emit) const {
  const Shape shape(region);
  Thinning thinning(region.resolution_m);
  ChunkWriter writer(chunk, emit);
  for (const TilePtr& tile : tiles(region.component)) {
    if (!shape.Touches(tile->bounds())) continue;
    const bool whole = shape.ContainsAll(tile->bounds());
    if (!HasPointsOf(*tile, region.robot)) continue;
    const absl::StatusOr<std::shared_ptr<const Cloud>> points = tile->Points();
    if (!points.ok()) return points.status();
    for (const TilePart& part : tile->parts()) {
      const uint32_t robot = index_of_number_[part.robot];
      if (region.robot >= 0 && robot != static_cast<uint32_t>(region.robot)) continue;
      for (uint32_t i = part.begin; i < part.end; ++i) {
        const Point& p = (**points)[i];
        if (!whole && !shape.Contains(p.Position().cast<double>())) continue;
        if (thinning.Passes(p) && !writer.Write(p, robot)) return absl::OkStatus();
      }
    }
  }
  writer.Flush();
  return absl::OkStatus();
}

}  // namespace isthmus::composition
