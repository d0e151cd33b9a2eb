#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include "storage/objects/large_values.h"
#include "storage/records/pose_codec.h"
#include "storage/sql/rows.h"

namespace isthmus::storage {
namespace {

// Values to a row and back.
void Put(int64_t value, Statement& to) { to.Bind(value); }
void Take(const Statement& row, int at, int64_t& value) { value = row.Int(at); }
void Put(uint64_t value, Statement& to) { to.Bind(value); }
void Take(const Statement& row, int at, uint64_t& value) { value = row.Uint(at); }
void Put(uint32_t value, Statement& to) { to.Bind(value); }
void Take(const Statement& row, int at, uint32_t& value) { value = row.Uint32(at); }
void Put(const std::string& value, Statement& to) { to.Bind(value); }
void Take(const Statement& row, int at, std::string& value) { value = row.Text(at); }
void Put(const SessionId& value, Statement& to) { to.Bind(value.value()); }
void Take(const Statement& row, int at, SessionId& value) { value = SessionId(row.Text(at)); }
void Put(const RobotId& value, Statement& to) { to.Bind(value.value()); }
void Take(const Statement& row, int at, RobotId& value) { value = RobotId(row.Text(at)); }
void Put(const Pose& value, Statement& to) { to.BindBlob(PackPose(value)); }
void Take(const Statement& row, int at, Pose& value) { value = UnpackPose(row.Text(at)); }
void Put(SessionState value, Statement& to) { to.Bind(value == SessionState::kActive ? 0 : 1); }
void Take(const Statement& row, int at, SessionState& value) {
  value = row.Int(at) == 0 ? SessionState::kActive : SessionState::kFinished;
}
void Put(WhenBehind value, Statement& to) { to.Bind(value == WhenBehind::kKeepNewest ? 1 : 0); }
void Take(const Statement& row, int at, WhenBehind& value) {
  value = row.Int(at) == 1 ? WhenBehind::kKeepNewest : WhenBehind::kWait;
}
void Put(const std::optional<OdometryMode>& value, Statement& to) {
  to.Bind(std::string(value ? ToString(*value) : ""));
}
// A mode that is unknown by now is the server's own choice, as the empty name.
void Take(const Statement& row, int at, std::optional<OdometryMode>& value) {
  value = FindOdometryMode(row.Text(at));
}

struct SessionColumn {
  const char* name;
  void (*put)(const SessionRecord& from, Statement& to);
  void (*take)(const Statement& row, int at, SessionRecord& to);
  const char* selected = nullptr;  // Null: the column itself, of s; f is the first segment.
  const char* given = "?";
};

template <auto kField>
constexpr SessionColumn Of(const char* name) {
  return {name, [](const SessionRecord& from, Statement& to) { Put(from.*kField, to); },
          [](const Statement& row, int at, SessionRecord& to) { Take(row, at, to.*kField); }};
}
template <auto kCount>
constexpr SessionColumn OfScans(const char* name) {
  return {name, [](const SessionRecord& from, Statement& to) { Put(from.scans.*kCount, to); },
          [](const Statement& row, int at, SessionRecord& to) { Take(row, at, to.scans.*kCount); }};
}
constexpr SessionColumn OfFirstSegment() {
  SessionColumn column = Of<&SessionRecord::first_segment>("first_segment");
  column.selected = "coalesce(f.id, '')";
  column.given = "(SELECT key FROM sessions WHERE id = ?)";
  return column;
}

constexpr SessionColumn kColumns[] = {
    Of<&SessionRecord::id>("id"),
    Of<&SessionRecord::robot>("robot"),
    Of<&SessionRecord::sensor>("sensor"),
    Of<&SessionRecord::T_base_sensor>("T_base_sensor"),
    Of<&SessionRecord::state>("state"),
    Of<&SessionRecord::created_ns>("created_ns"),
    Of<&SessionRecord::finished_ns>("finished_ns"),
    Of<&SessionRecord::odometry>("odometry"),
    Of<&SessionRecord::request_id>("request_id"),
    Of<&SessionRecord::segment>("segment"),
    OfFirstSegment(),
    OfScans<&ScanCounts::ok>("scans_ok"),
    OfScans<&ScanCounts::degenerate>("scans_degenerate"),
    OfScans<&ScanCounts::lost>("scans_lost"),
    OfScans<&ScanCounts::rejected>("scans_rejected"),
    Of<&SessionRecord::when_behind>("when_behind"),
    OfScans<&ScanCounts::skipped>("scans_skipped"),
};

std::string JoinedColumns(std::string (*part)(const SessionColumn& column)) {
  return absl::StrJoin(kColumns, ", ", [part](std::string* out, const SessionColumn& column) {
    out->append(part(column));
  });
}

const std::string& SelectSql() {
  static const std::string kSql =
      absl::StrCat("SELECT ", JoinedColumns([](const SessionColumn& column) {
                     return column.selected != nullptr ? std::string(column.selected)
                                                       : absl::StrCat("s.", column.name);
                   }),
                   " FROM sessions s LEFT JOIN sessions f ON f.key = s.first_segment");
  return kSql;
}

SessionRecord ReadRecord(const Statement& row) {
  SessionRecord record;
  int at = 0;
  for (const SessionColumn& column : kColumns) column.take(row, at++, record);
  return record;
}

}  // namespace

absl::Status PutSession(Connection& database, const SessionRecord& record) {
  static const std::string kSql = absl::StrCat(
      "INSERT INTO sessions (",
      JoinedColumns([](const SessionColumn& column) { return std::string(column.name); }),
      ") VALUES (",
      JoinedColumns([](const SessionColumn& column) { return std::string(column.given); }),
      ") ON CONFLICT (id) DO UPDATE SET ", JoinedColumns([](const SessionColumn& column) {
        return absl::StrCat(column.name, " = excluded.", column.name);
      }));
  Statement statement = database.Prepare(kSql);
  for (const SessionColumn& column : kColumns) column.put(record, statement);
  return statement.Run();
}

absl::StatusOr<std::optional<SessionRecord>> FindSession(Connection& database,
                                                         const SessionId& session) {
  Statement row = database.Prepare(SelectSql() + " WHERE s.id = ?");
  absl::StatusOr<bool> found = row.Bind(session.value()).Step();
  if (!found.ok()) return found.status();
  if (!*found) return std::nullopt;
  return ReadRecord(row);
}

absl::StatusOr<std::optional<int64_t>> FindSessionKey(Connection& database,
                                                      const SessionId& session) {
  Statement row = database.Prepare("SELECT key FROM sessions WHERE id = ?");
  absl::StatusOr<bool> found = row.Bind(session.value()).Step();
  if (!found.ok()) return found.status();
  if (!*found) return std::nullopt;
  return row.Int(0);
}

absl::StatusOr<std::vector<SessionRecord>> SelectSessions(Connection& database) {
  return database.Prepare(SelectSql() + " ORDER BY s.key").ReadAll(ReadRecord);
}

absl::StatusOr<bool> RemoveSession(Connection& database, const SessionId& session) {
  const absl::StatusOr<int64_t> removed =
      database.Prepare("DELETE FROM sessions WHERE id = ?").Bind(session.value()).Change();
  if (!removed.ok()) return removed.status();
  return *removed > 0;
}

// The length of a blob is known from its row: the blobs themselves are not read.
absl::StatusOr<uint64_t> SumBytes(Connection& database, int64_t session_key) {
  uint64_t bytes = 0;
  for (const char* table : {"submap_blobs", "features"}) {
    const std::string from = absl::StrCat(" FROM submaps JOIN ", table,
                                          " ON submap = submaps.key WHERE session = ? AND length("
                                          "data) ");
    Statement sum = database.Prepare(
        absl::StrCat("SELECT coalesce(sum(length(data)), 0)", from, "> ", kLongestReference));
    if (auto has_row = sum.Bind(session_key).Step(); !has_row.ok()) return has_row.status();
    bytes += sum.Uint(0);
    const auto small = database.Prepare(absl::StrCat("SELECT data", from, "<= ", kLongestReference))
                           .Bind(session_key)
                           .ReadAll([](const Statement& row) { return BytesOfValue(row.Text(0)); });
    if (!small.ok()) return small.status();
    for (const uint64_t each : *small) bytes += each;
  }
  return bytes;
}

}  // namespace isthmus::storage
