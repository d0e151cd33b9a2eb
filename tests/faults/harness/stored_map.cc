#include "tests/faults/harness/stored_map.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "fleet/postgresql/postgres_store.h"
#include "storage/sqlite/sqlite_store.h"
#include "tests/faults/harness/or_throw.h"

namespace isthmus::faults {
namespace {

bool SameBits(const Pose& a, const Pose& b) {
  return a.translation() == b.translation() && a.rotation().coeffs() == b.rotation().coeffs();
}

bool SamePoints(const Submap& a, const Submap& b) {
  return std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(),
                    [](const SubmapPoint& p, const SubmapPoint& q) {
                      return p.Position() == q.Position() && p.intensity == q.intensity &&
                             p.keyframe == q.keyframe;
                    }) &&
         std::equal(a.keyframes.begin(), a.keyframes.end(), b.keyframes.begin(), b.keyframes.end(),
                    [](const Keyframe& k, const Keyframe& l) {
                      return k.sequence == l.sequence && k.stamp_ns == l.stamp_ns &&
                             SameBits(k.T_submap_sensor, l.T_submap_sensor);
                    });
}

class Comparison {
 public:
  void Sessions(const StoredSession& reference, const StoredSession& session) {
    Trajectories(reference, session);
    Submaps(reference, session);
  }

  MapDifference Result() {
    if (compared_ > 0) difference_.rmse_m = std::sqrt(squares_ / static_cast<double>(compared_));
    difference_.same_bits &= difference_.missing_scans + difference_.odd_scans +
                                 difference_.repeated_scans + difference_.other_submaps +
                                 difference_.other_points ==
                             0;
    return difference_;
  }

 private:
  void Trajectories(const StoredSession& reference, const StoredSession& session) {
    std::map<uint64_t, const TrajectoryEntry*> found;
    for (const TrajectoryEntry& entry : session.trajectory) {
      ++difference_.scans;
      if (!found.emplace(entry.sequence, &entry).second) ++difference_.repeated_scans;
    }
    for (const TrajectoryEntry& wanted : reference.trajectory) {
      const auto it = found.find(wanted.sequence);
      if (it == found.end()) {
        ++difference_.missing_scans;
        continue;
      }
      const TrajectoryEntry& entry = *it->second;
      const double apart =
          (entry.T_odom_sensor.translation() - wanted.T_odom_sensor.translation()).norm();
      squares_ += apart * apart;
      ++compared_;
      difference_.max_m = std::max(difference_.max_m, apart);
      difference_.same_bits &= SameBits(entry.T_odom_sensor, wanted.T_odom_sensor) &&
                               entry.stamp_ns == wanted.stamp_ns &&
                               entry.submap_index == wanted.submap_index;
      found.erase(it);
    }
    difference_.odd_scans += found.size();
  }

  void Submaps(const StoredSession& reference, const StoredSession& session) {
    difference_.submaps += session.submaps.size();
    const size_t both = std::min(reference.submaps.size(), session.submaps.size());
    difference_.other_submaps += std::max(reference.submaps.size(), session.submaps.size()) - both;
    for (size_t i = 0; i < both; ++i) {
      const Submap& a = *reference.submaps[i];
      const Submap& b = *session.submaps[i];
      if (a.id != b.id || a.first_sequence != b.first_sequence ||
          a.last_sequence != b.last_sequence) {
        ++difference_.other_submaps;
      } else if (!SamePoints(a, b) || !SameBits(a.T_odom_submap, b.T_odom_submap)) {
        ++difference_.other_points;
      }
    }
  }

  MapDifference difference_;
  double squares_ = 0;
  uint64_t compared_ = 0;
};

}  // namespace

StoredMap ReadStoredMap(const std::string& folder, const std::string& database) {
  const auto store = OrThrow(database.empty() ? storage::OpenSqliteStore(folder)
                                              : storage::OpenPostgresStore(database, ""));
  StoredMap map;
  for (const SessionRecord& record : OrThrow(store->ListSessions())) {
    StoredSession& session = map[record.id];
    session.trajectory = OrThrow(store->GetTrajectory(record.id));
    for (const SubmapInfo& info : OrThrow(store->ListSubmaps(record.id))) {
      session.submaps.push_back(OrThrow(store->GetSubmap(info.id)));
    }
  }
  return map;
}

MapDifference Compare(const StoredMap& reference, const StoredMap& map) {
  Comparison comparison;
  const StoredSession nothing;
  for (const auto& [id, session] : reference) {
    const auto it = map.find(id);
    comparison.Sessions(session, it == map.end() ? nothing : it->second);
  }
  for (const auto& [id, session] : map) {
    if (reference.count(id) == 0) comparison.Sessions(nothing, session);
  }
  return comparison.Result();
}

}  // namespace isthmus::faults
