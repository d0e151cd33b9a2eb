#include "server/matching/loops/loop_submaps.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "server/matching/loops/limits.h"
#include "server/matching/registration/limits.h"

namespace isthmus::matching {
namespace {

double PathLengthWithin(const Submap& submap) {
  double path_length = 0;
  for (size_t i = 1; i < submap.keyframes.size(); ++i) {
    path_length += (submap.keyframes[i].T_submap_sensor.translation() -
                    submap.keyframes[i - 1].T_submap_sensor.translation())
                       .norm();
  }
  return path_length;
}

// From the last keyframe of one to the first of the other.
double PathLengthBetween(const Submap& from, const Submap& to) {
  const Pose& T_end = from.keyframes.back().T_submap_sensor;
  return (from.T_odom_submap * T_end.translation() - to.T_odom_submap.translation()).norm();
}

}  // namespace

LoopSubmaps::LoopSubmaps(SubmapSource source, size_t capacity, SubmapReader points,
                         std::map<uint32_t, double>* radii_m)
    : source_(std::move(source)),
      points_(std::move(points)),
      capacity_(std::max(capacity, kMinPreparedSubmaps)),
      radii_m_(radii_m) {}

SessionMap LoopSubmaps::MapOf(const std::vector<std::shared_ptr<const Submap>>& submaps) const {
  return {submaps.front()->id.session, submaps, points_};
}

std::shared_ptr<const PreparedMap> LoopSubmaps::Prepared(
    const std::shared_ptr<const Submap>& submap) {
  const uint32_t index = submap->id.index;
  if (const auto* used = used_.Use(index)) {
    radii_m_->emplace(index, facts_.at(index).radius_m);
    return *used;
  }
  auto prepared = std::make_shared<const PreparedMap>(MapOf({submap}), source_);
  if (facts_.count(index) == 0) {
    Facts facts{prepared->submaps().front()->radius_m(), prepared->places()};
    for (Place& place : facts.places) {
      place.T_odom_place = submap->T_odom_submap.Inverse() * place.T_odom_place;
    }
    facts_.emplace(index, std::move(facts));
  }
  radii_m_->emplace(index, facts_.at(index).radius_m);
  if (used_.size() >= capacity_) used_.DropOldest();
  used_.Put(index, prepared);
  return prepared;
}

PreparedMap LoopSubmaps::Window(const std::vector<std::shared_ptr<const Submap>>& submaps) {
  const SubmapSource kept = [this](const std::shared_ptr<const Submap>& submap) {
    return Prepared(submap)->submaps().front();
  };
  return PreparedMap(MapOf(submaps), kept);
}

const std::vector<Place>& LoopSubmaps::Places(const std::shared_ptr<const Submap>& submap) {
  const uint32_t index = submap->id.index;
  if (!facts_.contains(index)) Prepared(submap);
  const Facts& facts = facts_.at(index);
  // A finder that has the facts from before remembers the radius too, like one that prepared it.
  radii_m_->emplace(index, facts.radius_m);
  return facts.places;
}

double LoopSubmaps::Radius(uint32_t index, double otherwise) const {
  const auto found = radii_m_->find(index);
  return found == radii_m_->end() ? otherwise : found->second;
}

void LoopSubmaps::KeepOnly(const std::vector<std::shared_ptr<const Submap>>& submaps) {
  const auto gone = [&](uint32_t index) {
    const auto at = std::lower_bound(
        submaps.begin(), submaps.end(), index,
        [](const auto& submap, uint32_t wanted) { return submap->id.index < wanted; });
    return at == submaps.end() || (*at)->id.index != index;
  };
  std::erase_if(facts_, [&](const auto& entry) { return gone(entry.first); });
  std::erase_if(*radii_m_, [&](const auto& entry) { return gone(entry.first); });
  used_.EraseIf(gone);
}

bool IsOutdoors(const PreparedMap& map) {
  return std::all_of(map.submaps().begin(), map.submaps().end(),
                     [](const auto& submap) { return submap->voxel_m() >= kOutdoorVoxelM; });
}

Eigen::Vector3d MiddleOf(const Submap& submap) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Keyframe& keyframe : submap.keyframes) sum += keyframe.T_submap_sensor.translation();
  return sum / static_cast<double>(std::max<size_t>(submap.keyframes.size(), 1));
}

std::vector<double> PathLengths(const std::vector<std::shared_ptr<const Submap>>& submaps) {
  std::vector<double> path_lengths;
  double path_length = 0;
  for (size_t k = 0; k < submaps.size(); ++k) {
    const double within = PathLengthWithin(*submaps[k]);
    path_lengths.push_back(path_length + 0.5 * within);
    path_length += within;
    if (k + 1 == submaps.size()) break;
    const double retired = submaps[k + 1]->id.index - submaps[k]->id.index - 1;
    path_length += PathLengthBetween(*submaps[k], *submaps[k + 1]) + retired * within;
  }
  return path_lengths;
}

}  // namespace isthmus::matching
