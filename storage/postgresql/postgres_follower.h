// The follower of a site's tables: finds what is new without reading all of them.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "storage/map_follower.h"
#include "storage/postgresql/postgresql.h"

namespace isthmus::storage {

// Each commit of the owner leaves its number behind, so that nothing is looked at while that is the
// same. Then tables are told from what they were by how many rows they have and by which
// transactions wrote those (`xmin`), which only the owner's do, one after the other. Submaps and
// trajectories, which only grow or go, are read from where they ended.
class PostgresFollower : public MapFollower {
 public:
  explicit PostgresFollower(std::unique_ptr<PostgresConnection> connection)
      : database_(std::move(connection)) {}

  absl::StatusOr<MapNews> Next() override;

 private:
  // A commit of an owner.
  struct Mark {
    int64_t epoch = 0, since_ns = 0, commit = 0;
    bool operator==(const Mark&) const = default;
  };
  struct Trail {
    SessionId session;
    int64_t last_sequence = -1;  // Of its trajectory, as read.
    bool is_active = true;
    bool is_read = false;  // To its end.
  };
  struct Known {
    Mark mark;
    // By table: tells apart what it holds.
    std::map<std::string, std::string> tables;
    int64_t submaps = 0, last_submap = 0;  // Rows, and the key of the last that came.
    int64_t revision = -1, event = 0;
    std::map<int64_t, Trail> trails;  // By the session's key, which is not given twice.
    bool has_more = false;            // Of trajectories.
  };

  absl::StatusOr<Mark> ReadMark(std::string* owner);
  // Whether what is known led to what the database holds.
  absl::Status CheckGoesOn(const Mark& mark);
  absl::Status ReadNews(Known* known, MapNews* news);
  absl::Status ReadTables(Known* known, MapNews* news);
  absl::Status ReadSubmaps(Known* known, MapNews* news);
  absl::Status ReadTrails(Known* known);
  absl::Status ReadTrajectories(Known* known, MapNews* news);
  absl::Status ReadRevision(Known* known, MapNews* news);

  const std::unique_ptr<PostgresConnection> database_;
  Known known_;
};

}  // namespace isthmus::storage
