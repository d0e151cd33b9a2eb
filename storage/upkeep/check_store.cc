#include "storage/upkeep/check_store.h"

#include <absl/strings/str_cat.h>

#include <filesystem>
#include <system_error>

#include "core/io/directory_lock.h"
#include "storage/sqlite/migrations.h"
#include "storage/sqlite/open_marker.h"
#include "storage/upkeep/log_check.h"
#include "storage/upkeep/record_checks.h"

namespace isthmus::storage {
namespace {

constexpr char kTheDatabase[] = "the database";

// Each row of `sql` that is not "ok" is damage.
void ReportRows(Connection& database, const std::string& sql, StoreReport& report) {
  ForEachRow(database, kTheDatabase, sql, report, [&](const Statement& row) {
    if (row.Text(0) != "ok") AddDamage(kTheDatabase, row.Text(0), report);
  });
}

void CheckFile(Connection& database, StoreReport& report) {
  ReportRows(database, "PRAGMA integrity_check(100)", report);
  ReportRows(database,
             "SELECT 'a record of ' || \"table\" || ' belongs to one of ' || parent || "
             "' that is not there' FROM pragma_foreign_key_check",
             report);
  ReportRows(database, "SELECT rtreecheck('main', 'submap_bounds')", report);
}

void CountRecords(Connection& database, StoreReport& report) {
  const auto count = [&](const char* table, int64_t& number) {
    const auto rows = database.ReadNumber(absl::StrCat("SELECT count(*) FROM ", table));
    if (rows.ok()) {
      number = *rows;
    } else {
      AddDamage(absl::StrCat("table ", table), std::string(rows.status().message()), report);
    }
  };
  count("sessions", report.sessions);
  count("submaps", report.submaps);
  count("trajectory", report.scans);
  count("features", report.features);
  count("matches", report.matches);
  count("revisions", report.revisions);
  if (report.schema >= 5) count("loops", report.loops);
  if (report.schema >= 6) count("checkpoints", report.checkpoints);
}

absl::Status ExpectFile(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_regular_file(path, error)) return absl::OkStatus();
  return absl::NotFoundError(absl::StrCat("there is no map: ", path, " does not exist"));
}

// The folder is locked.
absl::StatusOr<StoreReport> ReadAll(const std::string& directory) {
  const std::string path = directory + "/isthmus.db";
  auto database = Connection::Open(path, Connection::Access::kReadOnly);
  if (!database.ok()) return database.status();
  StoreReport report;
  CheckLog(path + "-wal", report);
  if (const std::string missing = MissingLog(directory); !missing.empty()) {
    AddDamage("the log", missing, report);
  }
  absl::Status status = CheckSchema(**database);
  if (absl::IsDataLoss(status)) {  // Not even its first page can be read.
    AddDamage(kTheDatabase, std::string(status.message()), report);
    return report;
  }
  if (!status.ok()) return status;
  const Transaction snapshot(**database, Transaction::Kind::kRead);
  if (!snapshot.status().ok()) return snapshot.status();
  const auto schema = (*database)->ReadNumber("PRAGMA user_version");
  if (!schema.ok()) return schema.status();
  report.schema = *schema;
  CheckFile(**database, report);
  if (report.schema == 0) return report;  // Made, and nothing in it yet.
  CountRecords(**database, report);
  CheckSubmaps(**database, report.schema, report);
  CheckFeatures(**database, report);
  if (report.schema >= 6) CheckCheckpoints(**database, report);
  CheckEdges(**database, report.schema, report);
  CheckPoses(**database, report.schema, report);
  return report;
}

}  // namespace

absl::StatusOr<StoreReport> CheckStore(const std::string& directory) {
  const std::string path = directory + "/isthmus.db";
  if (absl::Status status = ExpectFile(path); !status.ok()) return status;
  const auto lock = io::DirectoryLock::TakeExisting(directory);
  if (!lock.ok()) return lock.status();
  const bool misses_log = !MissingLog(directory).empty();
  absl::StatusOr<StoreReport> report = ReadAll(directory);
  if (misses_log) {
    // SQLite makes an empty one to read; who starts a server next is to miss it, too.
    std::error_code ignored;
    const std::string log = path + "-wal";
    if (std::filesystem::file_size(log, ignored) == 0) std::filesystem::remove(log, ignored);
  }
  return report;
}

std::string ToString(const StoreReport& report) {
  std::string text = absl::StrCat(
      "schema ", report.schema, ": ", report.sessions, " sessions, ", report.submaps,
      " submaps of ", report.points, " points, ", report.scans, " scans, ", report.features,
      " features, ", report.matches, " matches, ", report.loops, " loop closures, ",
      report.revisions, " revisions, ", report.checkpoints, " checkpoints\n");
  for (const DamagedRecord& damaged : report.damaged) {
    absl::StrAppend(&text, damaged.record, ": ", damaged.problem, "\n");
  }
  const int64_t more = report.damaged_count - static_cast<int64_t>(report.damaged.size());
  if (more > 0) absl::StrAppend(&text, "and ", more, " more\n");
  absl::StrAppend(&text, report.damaged_count == 0 ? "sound" : "DAMAGED", "\n");
  return text;
}

}  // namespace isthmus::storage
