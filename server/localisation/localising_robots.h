// The robots that are being found in the map, one place for each stream of their scans.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <vector>

#include "core/clock.h"
#include "core/concurrency/mutex.h"
#include "core/ids.h"
#include "core/records/localisation.h"
#include "core/records/robot_place.h"

namespace isthmus::localisation {

// Thread safe; must outlive what it lets in.
class LocalisingRobots {
 private:
  struct Row {
    RobotPlace place;         // With Localising; its lag is counted when it is listed.
    bool is_waiting = false;  // Its newest scan has not been dealt with.
  };

 public:
  // A robot's place in the list; leaves it when destroyed.
  class Member {
   public:
    ~Member();
    Member(const Member&) = delete;
    Member& operator=(const Member&) = delete;

    void NoteScan();
    // Notes the outcome of the scan noted last, whose END that stamp is.
    void NotePlace(const LocalisedScan& scan, int64_t end_stamp_ns);

   private:
    friend class LocalisingRobots;
    Member(LocalisingRobots& robots, std::list<Row>::iterator row) : robots_(robots), row_(row) {}
    LocalisingRobots& robots_;
    const std::list<Row>::iterator row_;
  };

  explicit LocalisingRobots(const Clock* clock) : clock_(*clock) {}

  std::unique_ptr<Member> Enter(const RobotId& robot);
  // In order of their names, then of their beginnings.
  std::vector<RobotPlace> List() const;

 private:
  const Clock& clock_;
  mutable Mutex mutex_;
  std::list<Row> rows_ ABSL_GUARDED_BY(mutex_);  // In order of their beginnings.
};

}  // namespace isthmus::localisation
