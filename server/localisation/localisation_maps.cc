#include "server/localisation/localisation_maps.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

#include "core/caught.h"
#include "core/stopwatch.h"
#include "server/localisation/limits.h"

namespace isthmus::localisation {
namespace {

// The lack of a place in the map: for good unless someone does something, or for a moment.
absl::Status NotPlaced(const server::MapView& view, absl::string_view why) {
  if (view.IsPlaced()) return absl::FailedPreconditionError(why);
  return absl::UnavailableError("new submaps are being placed in the map: ask again in a moment");
}

absl::StatusOr<uint32_t> ComponentOf(const server::MapView& view, const RobotId& robot) {
  if (robot.empty()) {
    if (!view.revision->placements.empty()) return 0;
    return NotPlaced(
        view, "there is no map yet in which a robot can be located: push a mapping robot first");
  }
  const server::SessionView* session = view.Newest(robot);
  if (session == nullptr) {
    return absl::NotFoundError(absl::StrCat("no robot \"", robot.value(), "\""));
  }
  const Placement* placement = view.PlacementOf(session->record.id);
  if (placement != nullptr) return placement->component;
  return NotPlaced(view, absl::StrCat("nothing of robot ", robot.value(),
                                      " is in the map yet: wait until it has a submap"));
}

// z of the map's frame points where that of the reference's base does.
Eigen::Quaterniond LevelOf(const server::MapView& view, uint32_t component) {
  for (const Placement& placement : view.revision->placements) {
    if (placement.component != component) continue;
    const server::SessionView* reference = view.Find(placement.reference);
    return reference == nullptr ? Eigen::Quaterniond::Identity()
                                : reference->record.T_base_sensor.rotation();
  }
  return Eigen::Quaterniond::Identity();
}

}  // namespace

std::optional<Pose> MotionBetween(const PlacedMap& before, const PlacedMap& after,
                                  const Eigen::Vector3d& position) {
  std::optional<Pose> motion;
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& [id, T_map_submap] : before.places) {
    const double distance = (T_map_submap.translation() - position).norm();
    if (distance >= nearest) continue;
    const auto there = after.places.find(id);
    if (there == after.places.end()) continue;
    nearest = distance;
    motion = there->second * T_map_submap.Inverse();
  }
  return motion;
}

LocalisationMaps::LocalisationMaps(std::function<std::shared_ptr<const server::MapView>()> views,
                                   SubmapReader submaps, const Clock* clock, Executor* executor)
    : views_(std::move(views)),
      submaps_(std::move(submaps)),
      clock_(*clock),
      executor_(*executor) {}

LocalisationMaps::~LocalisationMaps() {
  MutexLock lock(&mutex_);
  while (!making_.empty()) changed_.Wait(&mutex_);
}

absl::StatusOr<std::shared_ptr<const PlacedMap>> LocalisationMaps::Make(const server::MapView& view,
                                                                        uint32_t component) const {
  try {
    return MakeUnguarded(view, component);
  } catch (...) {
    return CaughtStatus();  // No memory, for one.
  }
}

absl::StatusOr<std::shared_ptr<const PlacedMap>> LocalisationMaps::MakeUnguarded(
    const server::MapView& view, uint32_t component) const {
  const Stopwatch watch;
  auto placed = view.PlacedSubmaps();
  std::erase_if(placed, [&](const PlacedSubmap& one) { return one.component != component; });
  std::sort(placed.begin(), placed.end(), [](const PlacedSubmap& a, const PlacedSubmap& b) {
    return std::tie(a.submap->first_stamp_ns, a.submap->id) <
           std::tie(b.submap->first_stamp_ns, b.submap->id);
  });
  auto made = std::make_shared<PlacedMap>();
  auto map = std::make_shared<floam::LocalisationMap>(LevelOf(view, component));
  for (const PlacedSubmap& one : placed) {
    const std::shared_ptr<const Submap> submap = submaps_(one.submap->id);
    if (submap == nullptr) continue;
    map->Add(*submap, one.T_map_submap);
    made->places.emplace(one.submap->id, one.T_map_submap);
  }
  if (made->places.empty()) {
    return absl::FailedPreconditionError("the map to be found in has no submaps that can be read");
  }
  made->revision = view.revision->revision;
  made->component = component;
  made->map = std::move(map);
  made->making_s = 1e-3 * watch.Ms();
  made->made_ns = clock_.NowNs();
  return made;
}

bool LocalisationMaps::IsDue(const PlacedMap& made, int64_t revision) const {
  const double age_s = 1e-9 * static_cast<double>(clock_.NowNs() - made.made_ns);
  return made.revision != revision &&
         age_s >= std::max(kLeastAgeS, kLeastAgeMakings * made.making_s);
}

void LocalisationMaps::MakeLater(uint32_t component) {
  executor_.Post(lane_, [this, component] {
    auto made = Make(*views_(), component);
    MutexLock lock(&mutex_);
    if (made.ok()) made_[component] = *std::move(made);  // Else what there is stays.
    making_.erase(component);
    changed_.SignalAll();
  });
}

absl::StatusOr<std::shared_ptr<const PlacedMap>> LocalisationMaps::Get(const RobotId& in_map_of) {
  const std::shared_ptr<const server::MapView> view = views_();
  const absl::StatusOr<uint32_t> component = ComponentOf(*view, in_map_of);
  if (!component.ok()) return component.status();
  {
    MutexLock lock(&mutex_);
    while (made_.count(*component) == 0 && making_.count(*component) > 0) changed_.Wait(&mutex_);
    const auto made = made_.find(*component);
    if (made != made_.end()) {
      if (IsDue(*made->second, view->revision->revision) && making_.insert(*component).second) {
        MakeLater(*component);
      }
      return made->second;
    }
    making_.insert(*component);
  }
  auto made = Make(*view, *component);
  MutexLock lock(&mutex_);
  making_.erase(*component);
  changed_.SignalAll();
  if (made.ok()) made_[*component] = *made;
  return made;
}

}  // namespace isthmus::localisation
