#include "server/localisation/localising_robots.h"

#include <algorithm>

namespace isthmus::localisation {

LocalisingRobots::Member::~Member() {
  MutexLock lock(&robots_.mutex_);
  robots_.rows_.erase(row_);
}

void LocalisingRobots::Member::NoteScan() {
  const int64_t now_ns = robots_.clock_.NowNs();
  MutexLock lock(&robots_.mutex_);
  Localising& localising = *row_->place.localising;
  localising.received_ns = now_ns;
  ++localising.scans;
  row_->is_waiting = true;
}

void LocalisingRobots::Member::NotePlace(const LocalisedScan& scan, int64_t end_stamp_ns) {
  MutexLock lock(&robots_.mutex_);
  row_->is_waiting = false;
  RobotPlace& place = row_->place;
  if (!scan.rejected.empty()) {
    ++place.localising->rejected;
    return;  // It says nothing of where the robot is.
  }
  place.localising->state = scan.state;
  place.localising->tracking = scan.tracking;
  place.stamp_ns = end_stamp_ns;
  place.component.reset();
  if (!scan.T_map_sensor) return;
  place.component = scan.component;
  place.T_map_sensor = *scan.T_map_sensor;
}

std::unique_ptr<LocalisingRobots::Member> LocalisingRobots::Enter(const RobotId& robot) {
  Row row;
  row.place.robot = robot;
  row.place.localising.emplace();
  row.place.localising->since_ns = clock_.NowNs();
  MutexLock lock(&mutex_);
  return std::unique_ptr<Member>(new Member(*this, rows_.insert(rows_.end(), std::move(row))));
}

std::vector<RobotPlace> LocalisingRobots::List() const {
  const int64_t now_ns = clock_.NowNs();
  std::vector<RobotPlace> places;
  {
    MutexLock lock(&mutex_);
    places.reserve(rows_.size());
    for (const Row& row : rows_) {
      RobotPlace& place = places.emplace_back(row.place);
      if (!row.is_waiting) continue;
      const int64_t waited_ns = now_ns - place.localising->received_ns;
      place.lag_ms = std::max(0.0, 1e-6 * static_cast<double>(waited_ns));
    }
  }
  std::ranges::stable_sort(places, {}, &RobotPlace::robot);
  return places;
}

}  // namespace isthmus::localisation
