#include <absl/strings/str_cat.h>

#include "storage/objects/large_values.h"
#include "storage/records/pose_codec.h"
#include "storage/sql/rows.h"

namespace isthmus::storage {
namespace {

constexpr char kSelect[] =
    "SELECT s.id, s.robot, s.sensor, s.T_base_sensor, s.state, s.created_ns, s.finished_ns, "
    "s.odometry, s.request_id, s.segment, coalesce(f.id, ''), s.scans_ok, s.scans_degenerate, "
    "s.scans_lost, "
    "s.scans_rejected, s.when_behind, s.scans_skipped FROM sessions s LEFT JOIN sessions f ON "
    "f.key = s.first_segment";

SessionRecord ReadRecord(const Statement& row) {
  SessionRecord record;
  record.id = SessionId(row.Text(0));
  record.robot = RobotId(row.Text(1));
  record.sensor = row.Text(2);
  record.T_base_sensor = UnpackPose(row.Text(3));
  record.state = row.Int(4) == 0 ? SessionState::kActive : SessionState::kFinished;
  record.created_ns = row.Int(5);
  record.finished_ns = row.Int(6);
  // A mode that is unknown by now is the server's own choice, as the empty name.
  record.odometry = FindOdometryMode(row.Text(7));
  record.request_id = row.Text(8);
  record.segment = row.Uint32(9);
  record.first_segment = SessionId(row.Text(10));
  record.scans = {row.Uint(11), row.Uint(12), row.Uint(13), row.Uint(14), row.Uint(16)};
  record.when_behind = row.Int(15) == 1 ? WhenBehind::kKeepNewest : WhenBehind::kWait;
  return record;
}

}  // namespace

absl::Status PutSession(Connection& database, const SessionRecord& record) {
  return database
      .Prepare(
          "INSERT INTO sessions (id, robot, sensor, T_base_sensor, state, created_ns, "
          "finished_ns, odometry, request_id, segment, first_segment, scans_ok, scans_degenerate, "
          "scans_lost, scans_rejected, when_behind, scans_skipped) VALUES (?, ?, ?, ?, ?, ?, ?, ?, "
          "?, ?, (SELECT key FROM sessions WHERE id = ?), ?, ?, ?, ?, ?, ?) ON CONFLICT (id) DO "
          "UPDATE SET "
          "robot = excluded.robot, sensor = excluded.sensor, "
          "T_base_sensor = excluded.T_base_sensor, state = excluded.state, "
          "created_ns = excluded.created_ns, finished_ns = excluded.finished_ns, "
          "odometry = excluded.odometry, request_id = excluded.request_id, "
          "segment = excluded.segment, first_segment = excluded.first_segment, "
          "scans_ok = excluded.scans_ok, scans_degenerate = excluded.scans_degenerate, "
          "scans_lost = excluded.scans_lost, scans_rejected = excluded.scans_rejected, "
          "when_behind = excluded.when_behind, scans_skipped = excluded.scans_skipped")
      .Bind(record.id.value())
      .Bind(record.robot.value())
      .Bind(record.sensor)
      .BindBlob(PackPose(record.T_base_sensor))
      .Bind(record.state == SessionState::kActive ? 0 : 1)
      .Bind(record.created_ns)
      .Bind(record.finished_ns)
      .Bind(std::string(record.odometry ? ToString(*record.odometry) : ""))
      .Bind(record.request_id)
      .Bind(int64_t{record.segment})
      .Bind(record.first_segment.value())
      .Bind(record.scans.ok)
      .Bind(record.scans.degenerate)
      .Bind(record.scans.lost)
      .Bind(record.scans.rejected)
      .Bind(int64_t{record.when_behind == WhenBehind::kKeepNewest ? 1 : 0})
      .Bind(record.scans.skipped)
      .Run();
}

absl::StatusOr<std::optional<SessionRecord>> FindSession(Connection& database,
                                                         const SessionId& session) {
  Statement row = database.Prepare(std::string(kSelect) + " WHERE s.id = ?");
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
  return database.Prepare(std::string(kSelect) + " ORDER BY s.key").ReadAll(ReadRecord);
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
