// The follower of a site's tables: finds the changes without reading all of them.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "fleet/postgresql/postgresql.h"
#include "storage/map_follower.h"

namespace isthmus::storage {

// Each commit of the owner leaves its number behind, so that nothing is looked at while that is the
// same. Then a table is told from its last state by the number of its rows and by the transactions
// that wrote them (`xmin`), which are the owner's alone, one after the other. Submaps and
// trajectories, which only grow or go, are read from where they ended.
class PostgresFollower : public MapFollower {
 public:
  explicit PostgresFollower(std::unique_ptr<PostgresConnection> connection)
      : database_(std::move(connection)) {}

  absl::StatusOr<StoreDelta> Next() override;

 private:
  // A commit of an owner.
  struct Mark {
    int64_t epoch = 0, since_ns = 0, commit = 0;
    bool operator==(const Mark&) const = default;
  };
  struct Trail {
    SessionId session;
    int64_t last_sequence = -1;  // Last entry of its trajectory, as read.
    bool is_active = true;
    bool is_read = false;  // To its end.
  };
  struct Known {
    Mark mark;
    // By table: a text that tells its contents apart.
    std::map<std::string, std::string> tables;
    int64_t submaps = 0, last_submap = 0;  // Rows, and the key of the last that came.
    int64_t revision = -1, event = 0;
    std::map<int64_t, Trail> trails;  // By the session's key, which is not given twice.
    bool has_more = false;            // More entries of trajectories wait.
  };

  absl::StatusOr<Mark> ReadMark(std::string* owner);
  // Checks that the known state led to the database's present one.
  absl::Status CheckGoesOn(const Mark& mark);
  absl::Status ReadDelta(Known* known, StoreDelta* delta);
  absl::Status ReadTables(Known* known, StoreDelta* delta);
  absl::Status ReadSubmaps(Known* known, StoreDelta* delta);
  absl::Status ReadTrails(Known* known);
  absl::Status ReadTrajectories(Known* known, StoreDelta* delta);
  absl::Status ReadRevision(Known* known, StoreDelta* delta);

  const std::unique_ptr<PostgresConnection> database_;
  Known known_;
};

}  // namespace isthmus::storage
