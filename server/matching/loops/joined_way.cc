#include "server/matching/loops/joined_way.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/se3.h"

namespace isthmus::matching {

JoinedWay::JoinedWay(const JoinedMap& old, const JoinedMap& fresh, const SubmapEdge& join,
                     bool old_backwards, bool fresh_backwards, size_t prepared_submaps)
    : old_(&old), fresh_(&fresh) {
  const auto last = [](const JoinedMap& map) { return map.path_lengths.size() - 1; };
  AddStops(old, old_backwards ? last(old) : 0, join.submap_a);
  old_count_ = stops_.size();
  AddStops(fresh, join.submap_b, fresh_backwards ? 0 : last(fresh));

  const auto T_odom = [](const JoinedMap& map, size_t k) {
    return map.map->session_map().submaps[k]->T_odom_submap;
  };
  const Pose T_old_fresh =
      T_odom(old, join.submap_a) * join.T_a_b * T_odom(fresh, join.submap_b).Inverse();
  for (size_t k = 0; k < stops_.size(); ++k) {
    outlines_.push_back(Outline(k, k < old_count_ ? Pose() : T_old_fresh));
    const PreparedSubmap& prepared = *stops_[k].of->map->submaps()[stops_[k].position];
    radii_m_.emplace(static_cast<uint32_t>(k), prepared.radius_m());
  }
  const SubmapSource source = [this](const std::shared_ptr<const Submap>& outline) {
    const Stop& stop = stops_[outline->id.index];
    const PreparedSubmap& prepared = *stop.of->map->submaps()[stop.position];
    return std::make_shared<const PreparedSubmap>(outline, prepared.voxel_m(), prepared.surface(),
                                                  prepared.views());
  };
  const SubmapReader points = [this](const SubmapId& id) {
    const Stop& stop = stops_[id.index];
    return stop.of->map->session_map().Whole(stop.position);
  };
  submaps_ = std::make_unique<LoopSubmaps>(source, prepared_submaps, points, &radii_m_);
}

void JoinedWay::AddStops(const JoinedMap& map, size_t from, size_t to) {
  const double begin = path_lengths_.empty() ? 0 : path_lengths_.back();
  for (size_t k = from;; k = from < to ? k + 1 : k - 1) {
    on_way_[{&map, k}] = stops_.size();
    stops_.push_back({&map, k});
    path_lengths_.push_back(begin + std::abs(map.path_lengths[k] - map.path_lengths[from]));
    if (k == to) break;
  }
}

Matrix6d JoinedWay::StepCovariance(size_t stop) const {
  if (stop == 0 || stop == old_count_) return Matrix6d::Zero();
  const auto& submaps = stops_[stop].of->map->session_map().submaps;
  const size_t from = stops_[stop - 1].position, to = stops_[stop].position;
  if (from < to) return submaps[to]->drift_covariance;
  const Matrix6d A = Adjoint(submaps[from]->T_odom_submap.Inverse() * submaps[to]->T_odom_submap);
  return A * submaps[from]->drift_covariance * A.transpose();
}

std::shared_ptr<const Submap> JoinedWay::Outline(size_t stop, const Pose& T_old_odom) const {
  const auto& submap = *stops_[stop].of->map->session_map().submaps[stops_[stop].position];
  auto outline = std::make_shared<Submap>();
  outline->id = {old_->map->session_map().session, static_cast<uint32_t>(stop)};
  outline->robot = submap.robot;
  outline->T_odom_submap = T_old_odom * submap.T_odom_submap;
  outline->drift_covariance = StepCovariance(stop);
  outline->first_sequence = submap.first_sequence;
  outline->last_sequence = submap.last_sequence;
  outline->first_stamp_ns = submap.first_stamp_ns;
  outline->last_stamp_ns = submap.last_stamp_ns;
  outline->keyframes = submap.keyframes;
  return outline;
}

std::vector<LoopEdge> JoinedWay::EdgesAmong(size_t count,
                                            const std::vector<SubmapEdge>& edges) const {
  std::vector<LoopEdge> among;
  const auto add = [&](const JoinedMap* of_a, size_t a, const JoinedMap* of_b, size_t b,
                       const Pose& T_a_b, const Matrix6d& information) {
    const auto on_a = on_way_.find({of_a, a}), on_b = on_way_.find({of_b, b});
    if (on_a == on_way_.end() || on_b == on_way_.end()) return;
    if (on_a->second >= count || on_b->second >= count) return;
    among.push_back({on_a->second, on_b->second, T_a_b, information});
  };
  for (const SubmapEdge& edge : edges) {
    add(old_, edge.submap_a, fresh_, edge.submap_b, edge.T_a_b, edge.information);
  }
  for (const JoinedMap* map : {old_, fresh_}) {
    const auto& shape = map->map->shape();
    for (size_t k = shape ? shape->steps() : 0; shape && k < shape->edges.size(); ++k) {
      const pose_graph::Edge& loop = shape->edges[k];
      add(map, static_cast<size_t>(loop.a), map, static_cast<size_t>(loop.b), loop.T_a_b,
          loop.information);
    }
  }
  return among;
}

LoopScene JoinedWay::SceneAt(size_t fresh, const std::vector<SubmapEdge>& edges,
                             const pose_graph::DriftModel& drift) const {
  const size_t count = on_way_.at({fresh_, fresh}) + 1;
  const auto end = static_cast<std::ptrdiff_t>(count);
  LoopScene scene;
  scene.submaps.assign(outlines_.begin(), outlines_.begin() + end);
  scene.path_lengths.assign(path_lengths_.begin(), path_lengths_.begin() + end);
  for (size_t k = 0; k < count; ++k) {
    scene.T_map_submap.push_back((*stops_[k].of->poses)[stops_[k].position]);
  }
  scene.edges = EdgesAmong(count, edges);
  for (const LoopEdge& edge : scene.edges) {
    scene.joined.emplace(static_cast<uint32_t>(edge.a), static_cast<uint32_t>(edge.b));
  }
  scene.known = LookBack(scene.submaps, scene.path_lengths, scene.edges, drift);
  return scene;
}

}  // namespace isthmus::matching
