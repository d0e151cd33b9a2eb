#include "storage/upkeep/record_checks.h"

#include <absl/strings/str_cat.h>

#include <functional>

#include "core/io/crc32c.h"
#include "storage/records/edge_codec.h"
#include "storage/records/matrix_codec.h"
#include "storage/records/pose_codec.h"
#include "storage/sql/rows.h"

namespace isthmus::storage {
namespace {

constexpr size_t kPoseSize = 7 * sizeof(double);

std::string ProblemOfPose(const std::string& bytes) {
  if (bytes.size() != kPoseSize) return absl::StrCat("its pose has ", bytes.size(), " bytes");
  return UnpackPose(bytes).IsFinite() ? "" : "its pose is not finite";
}

struct Column {
  int64_t since;     // The schema that brought it.
  const char* name;  // SQL that names the record.
  const char* table;
  const char* column;
};

constexpr Column kPoses[] = {
    {1, "'session ' || id", "sessions", "T_base_sensor"},
    {1, "'scan ' || sequence || ' of session ' || s.id",
     "trajectory t LEFT JOIN sessions s "
     "ON s.key = t.session",
     "T_odom_sensor"},
    {1, "'submap ' || e.id || '/' || submap_index",
     "submaps s LEFT JOIN sessions e "
     "ON e.key = s.session",
     "T_odom_submap"},
    {1,
     "'match ' || (SELECT id FROM sessions WHERE key = a) || ' ~ ' || "
     "(SELECT id FROM sessions WHERE key = b)",
     "matches", "T_a_b"},
    {9,
     "'rival ' || position || ' of match ' || (SELECT id FROM sessions WHERE key = a) || ' ~ ' || "
     "(SELECT id FROM sessions WHERE key = b)",
     "match_rivals", "T_a_b"},
    {3,
     "'manual decision on ' || (SELECT id FROM sessions WHERE key = a) || ' ~ ' || "
     "(SELECT id FROM sessions WHERE key = b)",
     "verdicts", "T_a_b"},
    {5, "'loop closure ' || id", "loops", "T_a_b"},
    {5, "'anchor of submap ' || e.id || '/' || submap_index",
     "anchors a JOIN submaps s "
     "ON s.key = a.submap JOIN sessions e ON e.key = s.session",
     "T_map_submap"},
    {1, "'placement of ' || session || ' in revision ' || revision", "placements", "T_map_odom"},
    {5, "'move of ' || session || '/' || submap_index || ' in revision ' || revision",
     "submap_moves", "T_before"},
    {5, "'move of ' || session || '/' || submap_index || ' in revision ' || revision",
     "submap_moves", "T_after"},
    {5, "'place of ' || session || '/' || submap_index", "placed_submaps", "T_map_submap"},
};

constexpr Column kEdges[] = {
    {4,
     "'edges of match ' || (SELECT id FROM sessions WHERE key = a) || ' ~ ' || "
     "(SELECT id FROM sessions WHERE key = b)",
     "matches", "edges"},
    {9,
     "'edges of rival ' || position || ' of match ' || (SELECT id FROM sessions WHERE key = a) || "
     "' ~ ' || (SELECT id FROM sessions WHERE key = b)",
     "match_rivals", "edges"},
    {5, "'edges of loop closure ' || id", "loops", "edges"},
};

// Numbers of submaps, which are of 32 bits wherever they are read.
constexpr Column kSubmapNumbers[] = {
    {1, "'scan ' || sequence || ' of session ' || s.id",
     "trajectory t LEFT JOIN sessions s "
     "ON s.key = t.session",
     "submap_index"},
    {1, "'a submap of ' || e.id", "submaps s LEFT JOIN sessions e ON e.key = s.session",
     "submap_index"},
    {14, "'matching progress of session ' || e.id",
     "matching_progress p LEFT JOIN sessions e ON e.key = p.session", "next_for_loops"},
    {14, "'matching progress of session ' || e.id",
     "matching_progress p LEFT JOIN sessions e ON e.key = p.session", "next_at_choice"},
    {5, "'a move of ' || session || ' in revision ' || revision", "submap_moves", "submap_index"},
    {5, "'a place of ' || session", "placed_submaps", "submap_index"},
};

// `problem` names the fault of a value; empty: none.
void CheckColumn(Connection& database, const Column& column, StoreReport& report,
                 const std::function<std::string(const std::string&)>& problem) {
  const std::string sql = absl::StrCat("SELECT ", column.name, ", ", column.column, " FROM ",
                                       column.table, " WHERE ", column.column, " IS NOT NULL");
  const std::string what = absl::StrCat("column ", column.column, " of ", column.table);
  ForEachRow(database, what, sql, report, [&](const Statement& row) {
    const std::string found = problem(row.Text(1));
    if (!found.empty()) AddDamage(row.Text(0), found, report);
  });
}

// Checks the submap's blob and the columns beside it.
absl::Status CheckSubmap(Connection& database, const SubmapId& id, StoreReport& report) {
  absl::StatusOr<SubmapRow> row = FindSubmap(database, id);
  if (!row.ok()) return row.status();
  absl::StatusOr<std::shared_ptr<const Submap>> submap = UnpackSubmap(*row);
  if (!submap.ok()) return submap.status();
  report.points += static_cast<int64_t>((*submap)->points.size());
  return absl::OkStatus();
}

}  // namespace

void AddDamage(const std::string& record, const std::string& problem, StoreReport& report) {
  ++report.damaged_count;
  if (report.damaged.size() < kDamagedListed) report.damaged.push_back({record, problem});
}

void ForEachRow(Connection& database, const std::string& what, const std::string& sql,
                StoreReport& report, const std::function<void(const Statement&)>& visit) {
  Statement row = database.Prepare(sql);
  while (true) {
    absl::StatusOr<bool> has_row = row.Step();
    if (!has_row.ok()) AddDamage(what, std::string(has_row.status().message()), report);
    if (!has_row.ok() || !*has_row) return;
    visit(row);
  }
}

void CheckSubmaps(Connection& database, int64_t schema, StoreReport& report) {
  // First their names, which takes few pages, so that a damaged one does not hide the others.
  std::vector<SubmapId> ids;
  ForEachRow(
      database, "the list of submaps",
      "SELECT e.id, s.submap_index FROM submaps s JOIN sessions e ON e.key = s.session WHERE "
      "s.submap_index BETWEEN 0 AND 4294967295",
      report, [&](const Statement& row) {
        ids.push_back({SessionId(row.Text(0)), row.Uint32(1)});
      });
  if (schema < 5) return;  // Their rows lack columns that are read of newer ones.
  for (const SubmapId& id : ids) {
    const absl::Status status = CheckSubmap(database, id, report);
    if (!status.ok()) AddDamage("submap " + ToString(id), std::string(status.message()), report);
  }
}

void CheckFeatures(Connection& database, StoreReport& report) {
  std::vector<int64_t> keys;
  ForEachRow(database, "the list of features", "SELECT key FROM features", report,
             [&](const Statement& row) { keys.push_back(row.Int(0)); });
  for (const int64_t key : keys) {
    Statement row = database.Prepare("SELECT crc32c, data FROM features WHERE key = ?");
    const absl::StatusOr<bool> found = row.Bind(key).Step();
    const std::string name = absl::StrCat("features ", key);
    if (!found.ok()) {
      AddDamage(name, std::string(found.status().message()), report);
    } else if (const std::string data = *found ? row.Text(1) : "";
               *found && io::Crc32c(data.data(), data.size()) != row.Uint(0)) {
      AddDamage(name, "their checksum is wrong; they are made anew", report);
    }
  }
}

void CheckCheckpoints(Connection& database, StoreReport& report) {
  std::vector<std::pair<int64_t, std::string>> sessions;
  ForEachRow(
      database, "the list of checkpoints",
      "SELECT session, coalesce(id, '') FROM checkpoints LEFT JOIN sessions ON key = session",
      report, [&](const Statement& row) { sessions.emplace_back(row.Int(0), row.Text(1)); });
  for (const auto& [key, id] : sessions) {
    const absl::StatusOr<std::optional<Checkpoint>> found = FindCheckpoint(database, key);
    const std::string name = absl::StrCat("checkpoint of session ", id);
    if (!found.ok()) {
      AddDamage(name, std::string(found.status().message()), report);
    } else if (*found && !(*found)->data) {
      AddDamage(name, "its data is damaged; the session goes on from its submaps", report);
    }
  }
}

void CheckEventLog(Connection& database, StoreReport& report) {
  int64_t before = 0;
  ForEachRow(database, "the event log", "SELECT number, kind FROM events ORDER BY number", report,
             [&](const Statement& row) {
               const int64_t number = row.Int(0);
               const std::string name = absl::StrCat("event ", number);
               if (before > 0 && number != before + 1) {
                 AddDamage(name, absl::StrCat("the one before it is ", before, ": some are lost"),
                           report);
               }
               if (ParseEventKind(row.Text(1)) == EventKind::kUnknown) {
                 AddDamage(name, "its kind is none", report);
               }
               before = number;
             });
}

void CheckEdges(Connection& database, int64_t schema, StoreReport& report) {
  for (const Column& column : kEdges) {
    if (schema < column.since) continue;
    CheckColumn(database, column, report, [](const std::string& blob) {
      std::vector<SubmapEdge> edges;
      return std::string(DecodeEdges(blob, edges).message());
    });
  }
}

void CheckSubmapNumbers(Connection& database, int64_t schema, StoreReport& report) {
  for (const Column& column : kSubmapNumbers) {
    if (schema < column.since) continue;
    const std::string sql =
        absl::StrCat("SELECT ", column.name, ", ", column.column, " FROM ", column.table, " WHERE ",
                     column.column, " NOT BETWEEN 0 AND 4294967295");
    ForEachRow(database, absl::StrCat("column ", column.column, " of ", column.table), sql, report,
               [&](const Statement& row) {
                 AddDamage(row.Text(0), absl::StrCat("no submap has the number ", row.Int(1)),
                           report);
               });
  }
}

void CheckPoses(Connection& database, int64_t schema, StoreReport& report) {
  for (const Column& column : kPoses) {
    if (schema >= column.since) CheckColumn(database, column, report, ProblemOfPose);
  }
}

}  // namespace isthmus::storage
