#include "server/composition/visibility/verdict.h"

#include <absl/container/flat_hash_map.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "server/composition/visibility/limits.h"

namespace isthmus::composition {
namespace {

struct Cell {
  int32_t x = 0, y = 0, z = 0;

  friend bool operator==(const Cell&, const Cell&) = default;
  template <typename H>
  friend H AbslHashValue(H h, const Cell& cell) {
    return H::combine(std::move(h), cell.x, cell.y, cell.z);
  }
};

Cell CellOf(const Eigen::Vector3f& at) {
  const auto index = [](float v, float edge_m) {
    return static_cast<int32_t>(std::floor(v / edge_m));
  };
  return {index(at.x(), kSameThingWideM), index(at.y(), kSameThingWideM),
          index(at.z(), kSameThingHighM)};
}

// True once `visit` is, of what a map by cells has in this one or beside it.
template <typename Value, typename Visit>
bool AnyAround(const absl::flat_hash_map<Cell, Value>& map, const Cell& cell, const Visit& visit) {
  for (int i = 0; i < 27; ++i) {
    const auto it = map.find({cell.x + i % 3 - 1, cell.y + i / 3 % 3 - 1, cell.z + i / 9 - 1});
    if (it != map.end() && visit(it->second)) return true;
  }
  return false;
}

// A submap's points, turned level around its origin.
class Upright {
 public:
  explicit Upright(const Pose& T_map_submap) : R_(T_map_submap.RotationMatrix().cast<float>()) {}
  Eigen::Vector3f operator()(const WeightedPoint& p) const {
    return R_ * Eigen::Vector3f(p.x, p.y, p.z);
  }

 private:
  const Eigen::Matrix3f R_;
};

// The points of a submap that are gone, by place.
class DroppedPoints {
 public:
  explicit DroppedPoints(const Upright& upright) : upright_(upright) {}

  bool empty() const { return gone_.empty(); }
  void AddGone(const WeightedPoint& point) {
    const Eigen::Vector3f at = upright_(point);
    const Cell cell = CellOf(at);
    gone_[cell].push_back({at, point.keyframe});
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        lowest_.try_emplace({cell.x + x, cell.y + y, 0}, std::numeric_limits<float>::infinity());
      }
    }
  }
  // Then of all points, in any order.
  void AddHeight(const WeightedPoint& point) {
    const Eigen::Vector3f at = upright_(point);
    const Cell cell = CellOf(at);
    const auto it = lowest_.find({cell.x, cell.y, 0});
    if (it != lowest_.end()) it->second = std::min(it->second, at.z());
  }
  // After all that.
  bool IsPartOfGone(const WeightedPoint& point) const {
    if (point.keyframes_after > kSameThingKeyframes) return false;
    const Eigen::Vector3f at = upright_(point);
    const Cell cell = CellOf(at);
    if (!lowest_.contains({cell.x, cell.y, 0}) || !StandsAboveGround(at, cell)) return false;
    const auto is_same_thing = [&](const Gone& gone) {
      const Eigen::Vector3f to = gone.at - at;
      return std::abs(to.z()) < kSameThingHighM &&
             to.head<2>().squaredNorm() < kSameThingWideM * kSameThingWideM &&
             std::abs(gone.keyframe - point.keyframe) <= kSameThingKeyframes;
    };
    return AnyAround(gone_, cell, [&](const std::vector<Gone>& there) {
      return std::ranges::any_of(there, is_same_thing);
    });
  }

 private:
  struct Gone {
    Eigen::Vector3f at;
    int keyframe = 0;
  };

  // Above the lowest point in or beside its column.
  bool StandsAboveGround(const Eigen::Vector3f& at, const Cell& cell) const {
    for (int i = 0; i < 9; ++i) {
      const auto it = lowest_.find({cell.x + i % 3 - 1, cell.y + i / 3 - 1, 0});
      if (it != lowest_.end() && at.z() >= it->second + kAboveGroundM) return true;
    }
    return false;
  }

  const Upright upright_;
  absl::flat_hash_map<Cell, std::vector<Gone>> gone_;
  absl::flat_hash_map<Cell, float> lowest_;  // Point of an upright column near what is gone.
};

int32_t Since(const WeightedPoint& point) { return point.own_looks + point.other_looks; }
int32_t All(const WeightedPoint& point) { return Since(point) + point.through_before; }

// Points that came, by place: they leave only by looks from before they were seen. A thing is in
// sight or is not, so its points are judged together: many a point is seen once, and says nothing
// by itself.
class NewThings {
 public:
  NewThings(std::span<const WeightedPoint> points, const Upright& upright) : upright_(upright) {
    for (const WeightedPoint& point : points) {
      if (All(point) >= kGoneBelow) continue;
      Looks& looks = looks_[CellOf(upright_(point))];
      ++looks.points;
      looks.seen_again += point.keyframes_after > 0;
      looks.since += Since(point);
      looks.first = std::min<int>(looks.first, point.keyframe);
      looks.last = std::max<int>(looks.last, point.keyframe + point.keyframes_after);
    }
  }
  // True if the point, one of these, stays in the map.
  bool Stands(const WeightedPoint& point) const {
    if (Since(point) < kGoneBelow) return false;
    Looks around;
    AnyAround(looks_, CellOf(upright_(point)), [&around](const Looks& there) {
      around.points += there.points;
      around.seen_again += there.seen_again;
      around.since += there.since;
      around.first = std::min(around.first, there.first);
      around.last = std::max(around.last, there.last);
      return false;
    });
    return around.since >= 0 && around.last - around.first >= kStandsKeyframes &&
           static_cast<float>(around.seen_again) >=
               kStandsSeenAgain * static_cast<float>(around.points);
  }

 private:
  // Sums over the points of a place, and the keyframes between which they were seen.
  struct Looks {
    int64_t since = 0;
    int points = 0, seen_again = 0;  // By more keyframes than one.
    int first = std::numeric_limits<int>::max(), last = std::numeric_limits<int>::min();
  };

  const Upright upright_;
  absl::flat_hash_map<Cell, Looks> looks_;
};

}  // namespace

void MarkGone(std::span<WeightedPoint> points, const Pose& T_map_submap) {
  const Upright upright(T_map_submap);
  DroppedPoints places(upright);
  const NewThings news(points, upright);
  for (WeightedPoint& point : points) {
    point.gone = All(point) < kGoneBelow && !news.Stands(point);
    if (point.gone) places.AddGone(point);
  }
  bool has_news = !places.empty();
  for (int round = 0; has_news && round < kSameThingRounds; ++round) {
    for (const WeightedPoint& point : points) places.AddHeight(point);
    std::vector<WeightedPoint*> parts;
    for (WeightedPoint& point : points) {
      if (point.gone || (round > 0 && All(point) > 0)) continue;
      if (places.IsPartOfGone(point)) parts.push_back(&point);
    }
    for (WeightedPoint* part : parts) {
      part->gone = true;
      places.AddGone(*part);
    }
    has_news = !parts.empty();
  }
}

}  // namespace isthmus::composition
