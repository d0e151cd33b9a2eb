#include "server/composition/visibility/visibility_filter.h"

#include <absl/container/flat_hash_map.h>

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "server/composition/thinned_submap.h"
#include "server/composition/visibility/limits.h"
#include "server/composition/visibility/verdict.h"
#include "server/composition/visibility/view_evidence.h"

namespace isthmus::composition {
namespace {

int16_t Saturated(int32_t value) {
  using Limits = std::numeric_limits<int16_t>;
  return static_cast<int16_t>(std::clamp<int32_t>(value, Limits::min(), Limits::max()));
}

// Fills in the keyframes that saw the voxel of each thinned point.
void FillInKeyframes(const Submap& submap, const VoxelGrid& grid,
                     std::vector<WeightedPoint>* points) {
  struct Seen {
    uint16_t first = 0, last = 0;
  };
  absl::flat_hash_map<uint64_t, Seen> seen;
  seen.reserve(points->size());
  for (const SubmapPoint& p : submap.points) {
    const auto voxel = grid.Find(p.x, p.y, p.z);
    if (!voxel) continue;
    seen.try_emplace(PackVoxel(*voxel), Seen{p.keyframe}).first->second.last = p.keyframe;
  }
  for (WeightedPoint& p : *points) {
    const auto voxel = grid.Find(p.x, p.y, p.z);
    const auto it = voxel ? seen.find(PackVoxel(*voxel)) : seen.end();
    if (it == seen.end()) continue;
    p.keyframe = it->second.first;
    p.keyframes_after =
        static_cast<uint8_t>(0x7f & std::min(127, it->second.last - it->second.first));
  }
}

bool IsSame(const Pose& a, const Pose& b) {
  return a.translation() == b.translation() && a.rotation().coeffs() == b.rotation().coeffs();
}

Box SensorsOf(const SubmapViews& views) {
  Box box;
  for (const View& view : views.views) box.Extend(view.T_submap_sensor.translation());
  return box;
}

}  // namespace

VisibilityFilter::VisibilityFilter(double same_pose_m, size_t max_bytes)
    : same_pose_m_(same_pose_m), max_bytes_(max_bytes) {}

bool VisibilityFilter::JudgeOwn(const Submap& submap, const VoxelGrid& grid, const KeepOn& keep_on,
                                std::vector<WeightedPoint>* points) {
  const auto views = std::make_shared<const SubmapViews>(MakeViews(submap));
  FillInKeyframes(submap, grid, points);
  std::vector<int32_t> says;
  const ViewEvidence evidence(*points);
  if (!evidence.Look(*views, Pose(), /*are_placed=*/false, keep_on, &says)) return false;
  for (size_t i = 0; i < points->size(); ++i) {
    (*points)[i].own_looks = static_cast<int8_t>(std::clamp(says[i], kMinOwn, kMaxOwn));
    (*points)[i].other_looks = (*points)[i].through_before = 0;
  }
  judged_[submap.id] = {SensorsOf(*views), submap.first_stamp_ns, submap.last_stamp_ns};
  KeepViews(submap.id, views);
  // The points do not hold the looks of other submaps any more.
  if (const auto it = entries_.find(submap.id); it != entries_.end()) it->second.asked.clear();
  return true;
}

void VisibilityFilter::Place(const SubmapId& id, uint32_t frame, const Pose& T_map_submap,
                             const Box& bounds) {
  Entry& entry = entries_[id];
  entry.frame = frame;
  entry.T_map_submap = T_map_submap;
  entry.bounds = bounds;
  entry.judged = judged_[id];
  changed_.insert(id);
}

void VisibilityFilter::Forget(const SubmapId& id) {
  judged_.erase(id);
  views_.Erase(id);
  if (entries_.erase(id) == 0) return;
  changed_.insert(id);
  forgotten_.insert(id);
}

bool VisibilityFilter::Reaches(const Entry& views, const Entry& points) const {
  if (views.frame != points.frame || views.judged.sensors.empty() || points.bounds.empty())
    return false;
  const Box reach = Transform(views.T_map_submap, views.judged.sensors).Grown(kFarthestLookM);
  return reach.Intersects(Transform(points.T_map_submap, points.bounds));
}

// The submaps to ask, with T_views_points: the same as before where nothing changed.
std::map<SubmapId, Pose> VisibilityFilter::WhomToAsk(const SubmapId& id, const Entry& entry) const {
  std::map<SubmapId, Pose> wanted;
  const auto consider = [&](const SubmapId& other) {
    const auto it = entries_.find(other);
    if (other == id || it == entries_.end() || !Reaches(it->second, entry)) return;
    Pose T_views_points = it->second.T_map_submap.Inverse() * entry.T_map_submap;
    const auto asked = entry.asked.find(other);
    if (asked != entry.asked.end() &&
        LargestMove(entry.bounds, asked->second, T_views_points) <= same_pose_m_) {
      T_views_points = asked->second;
    }
    wanted.emplace(other, T_views_points);
  };
  if (changed_.contains(id)) {
    for (const auto& [other, unused] : entries_) consider(other);
    return wanted;
  }
  for (const auto& [other, T_views_points] : entry.asked) {
    if (!changed_.contains(other)) wanted.emplace(other, T_views_points);
  }
  for (const SubmapId& other : changed_) consider(other);
  return wanted;
}

void VisibilityFilter::KeepViews(const SubmapId& id, std::shared_ptr<const SubmapViews> views) {
  const size_t bytes = views->bytes();
  views_.Put(id, std::move(views), bytes);
  while (views_.weight() > max_bytes_) views_.DropOldest();
}

std::shared_ptr<const SubmapViews> VisibilityFilter::ViewsOf(const SubmapId& id,
                                                             const SubmapReader& reader) {
  if (const auto* kept = views_.Use(id)) return *kept;
  const std::shared_ptr<const Submap> submap = reader(id);
  if (submap == nullptr) return nullptr;
  auto views = std::make_shared<const SubmapViews>(MakeViews(*submap));
  KeepViews(id, views);
  return views;
}

// Asks only those who were not asked yet, unless something that was said is no longer so.
absl::Status VisibilityFilter::Ask(const SubmapId& id, Entry* entry, const SubmapReader& reader,
                                   ThinnedSubmapCache* thinned, const OnChange& on_change,
                                   const KeepOn& keep_on) {
  std::map<SubmapId, Pose> wanted = WhomToAsk(id, *entry);
  const bool anew = std::ranges::any_of(entry->asked, [&](const auto& asked) {
    const auto it = wanted.find(asked.first);
    return it == wanted.end() || !IsSame(it->second, asked.second) ||
           forgotten_.contains(asked.first);
  });
  const bool has_news = anew || changed_.contains(id) || wanted.size() > entry->asked.size();
  if (!has_news) return absl::OkStatus();
  if (anew) entry->asked.clear();
  bool ended = false;
  std::vector<int32_t> says;
  const auto change = [&](std::span<WeightedPoint> points) {
    const auto forget = [&] {
      for (WeightedPoint& point : points) point.other_looks = point.through_before = 0;
    };
    if (entry->asked.empty()) forget();
    const ViewEvidence evidence(points);
    for (const auto& [other, T_views_points] : wanted) {
      if (entry->asked.contains(other)) continue;
      const std::shared_ptr<const SubmapViews> views = ViewsOf(other, reader);
      if (views == nullptr) continue;
      ended = !evidence.Look(*views, T_views_points, /*are_placed=*/true, keep_on, &says);
      if (ended) return forget();
      const bool is_before =
          entries_.at(other).judged.last_stamp_ns <= entry->judged.first_stamp_ns;
      for (size_t i = 0; i < points.size(); ++i) {
        const int32_t said = std::clamp(says[i], kMinOther, kMaxOther);
        int16_t& sum = is_before && said < 0 ? points[i].through_before : points[i].other_looks;
        sum = Saturated(sum + said);
      }
    }
    MarkGone(points, entry->T_map_submap);
  };
  const absl::StatusOr<std::vector<size_t>> tiles = thinned->Change(id, change);
  if (!tiles.ok()) return tiles.status();
  if (!tiles->empty()) on_change(id, *tiles);
  if (ended) {
    entry->asked.clear();
    changed_.insert(id);
    return absl::CancelledError("stopped");
  }
  entry->asked = std::move(wanted);
  return absl::OkStatus();
}

absl::Status VisibilityFilter::Update(const SubmapReader& reader, ThinnedSubmapCache* thinned,
                                      const OnChange& on_change, const KeepOn& keep_on,
                                      std::optional<SubmapId>* at_hand) {
  if (changed_.empty()) return absl::OkStatus();
  for (auto& [id, entry] : entries_) {
    if (!keep_on()) return absl::CancelledError("stopped");
    *at_hand = id;
    absl::Status status = Ask(id, &entry, reader, thinned, on_change, keep_on);
    if (status.ok()) status = thinned->KeepToMemory();
    if (!status.ok()) return status;
  }
  changed_.clear();
  forgotten_.clear();
  return absl::OkStatus();
}

}  // namespace isthmus::composition
