#include "storage/upkeep/check_store.h"

#include <absl/strings/str_cat.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>
#include <vector>

#include "core/io/directory_lock.h"
#include "storage/sqlite/migrations.h"
#include "storage/sqlite/open_marker.h"
#include "storage/upkeep/record_checks.h"

namespace isthmus::storage {
namespace {

using Bytes = std::vector<unsigned char>;

constexpr size_t kHeaderSize = 32;
constexpr size_t kFrameHeaderSize = 24;
constexpr uint32_t kLogMagic = 0x377f0682;  // Its last bit: sums are over big-endian words.
constexpr uint32_t kMaxPageSize = 65536;

uint32_t Number(const Bytes& bytes, size_t at) {
  return uint32_t{bytes[at]} << 24 | uint32_t{bytes[at + 1]} << 16 | uint32_t{bytes[at + 2]} << 8 |
         uint32_t{bytes[at + 3]};
}

struct Checksum {
  uint32_t a = 0, b = 0;

  void Add(const Bytes& bytes, size_t begin, size_t end, bool is_big_endian) {
    for (size_t at = begin; at < end; at += 8) {
      a += Word(bytes, at, is_big_endian) + b;
      b += Word(bytes, at + 4, is_big_endian) + a;
    }
  }
  bool Is(const Bytes& bytes, size_t at) const {
    return a == Number(bytes, at) && b == Number(bytes, at + 4);
  }

 private:
  static uint32_t Word(const Bytes& bytes, size_t at, bool is_big_endian) {
    return is_big_endian ? Number(bytes, at) : __builtin_bswap32(Number(bytes, at));
  }
};

bool Read(std::ifstream& file, Bytes& bytes) {
  return bool(
      file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())));
}

// SQLite takes the log at `path` up to the first frame whose checksum is wrong, and says nothing of
// the rest. A power cut may leave the last transaction like that, which was not acknowledged then;
// a break before another one has begun is damage. No log is none.
//
// Source of the format: https://www.sqlite.org/fileformat2.html, "The Write-Ahead Log".
void CheckLog(const std::string& path, StoreReport& report) {
  std::ifstream file(path, std::ios::binary);
  Bytes header(kHeaderSize);
  if (!file || !Read(file, header)) return;
  const bool is_big_endian = (Number(header, 0) & 1) != 0;
  const uint32_t page_size = Number(header, 8);
  Checksum sum;
  sum.Add(header, 0, 24, is_big_endian);
  if ((Number(header, 0) & ~1u) != kLogMagic || page_size > kMaxPageSize || !sum.Is(header, 24)) {
    return AddDamage("the write-ahead log", "its header is broken: none of it is used", report);
  }
  Bytes frame(kFrameHeaderSize + page_size);
  int64_t number = 0, broken = 0, commits = 0;  // `commits` from the broken frame on.
  bool goes_on = false;                         // Something was written behind one of these.
  while (Read(file, frame)) {
    ++number;
    // Left from before the log was begun anew.
    if (Number(frame, 8) != Number(header, 16) || Number(frame, 12) != Number(header, 20)) {
      if (broken == 0) broken = number;
      continue;
    }
    if (broken == 0) {
      sum.Add(frame, 0, 8, is_big_endian);
      sum.Add(frame, kFrameHeaderSize, frame.size(), is_big_endian);
      if (!sum.Is(frame, 16)) broken = number;
    }
    if (broken == 0) continue;
    goes_on = goes_on || commits > 0;
    if (Number(frame, 4) != 0) ++commits;
  }
  if (!goes_on) return;
  AddDamage("the write-ahead log",
            absl::StrCat("frame ", broken, " of ", number, " is broken; ", commits,
                         " commits from there on are lost"),
            report);
}

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
  if (report.schema >= 12) count("events", report.events);
}

absl::Status ExpectMap(const std::string& directory) {
  const std::string path = directory + "/isthmus.db";
  std::error_code error;
  if (std::filesystem::is_regular_file(path, error)) return absl::OkStatus();
  if (const std::string unfinished = UnfinishedCopy(directory); !unfinished.empty()) {
    return absl::NotFoundError(absl::StrCat("there is no map: ", unfinished));
  }
  return absl::NotFoundError(absl::StrCat("there is no map: ", path, " does not exist"));
}

// The folder is locked.
absl::StatusOr<StoreReport> ReadAll(const std::string& directory) {
  const std::string path = directory + "/isthmus.db";
  auto database = SqliteConnection::Open(path, SqliteConnection::Access::kReadOnly);
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
  CheckSubmapNumbers(**database, report.schema, report);
  CheckFeatures(**database, report);
  if (report.schema >= 6) CheckCheckpoints(**database, report);
  if (report.schema >= 12) CheckEventLog(**database, report);
  CheckEdges(**database, report.schema, report);
  CheckPoses(**database, report.schema, report);
  return report;
}

}  // namespace

absl::StatusOr<StoreReport> CheckStore(const std::string& directory) {
  const std::string path = directory + "/isthmus.db";
  if (absl::Status status = ExpectMap(directory); !status.ok()) return status;
  const auto lock = io::DirectoryLock::TakeExisting(directory);
  if (!lock.ok()) return lock.status();
  const bool misses_log = !MissingLog(directory).empty();
  absl::StatusOr<StoreReport> report = ReadAll(directory);
  if (misses_log) {
    // SQLite makes an empty one to read; the next start of a server is to miss it, too.
    std::error_code ignored;
    const std::string log = path + "-wal";
    if (std::filesystem::file_size(log, ignored) == 0) std::filesystem::remove(log, ignored);
  }
  return report;
}

std::string ToString(const StoreReport& report) {
  std::string text =
      absl::StrCat("schema ", report.schema, ": ", report.sessions, " sessions, ", report.submaps,
                   " submaps of ", report.points, " points, ", report.scans, " scans, ",
                   report.features, " features, ", report.matches, " matches, ", report.loops,
                   " loop closures, ", report.revisions, " revisions, ", report.checkpoints,
                   " checkpoints, ", report.events, " events\n");
  for (const DamagedRecord& damaged : report.damaged) {
    absl::StrAppend(&text, damaged.record, ": ", damaged.problem, "\n");
  }
  const int64_t more = report.damaged_count - static_cast<int64_t>(report.damaged.size());
  if (more > 0) absl::StrAppend(&text, "and ", more, " more\n");
  absl::StrAppend(&text, report.damaged_count == 0 ? "sound" : "DAMAGED", "\n");
  return text;
}

}  // namespace isthmus::storage
