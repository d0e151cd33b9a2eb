#include "storage/records/pose_codec.h"
#include "storage/sql/rows.h"

namespace isthmus::storage {

absl::Status AddTrajectory(Connection& database,
                           const std::vector<std::pair<SessionId, TrajectoryEntry>>& entries) {
  Statement insert = database.Prepare(
      "INSERT INTO trajectory (session, sequence, stamp_ns, submap_index, T_odom_sensor) "
      "VALUES (?, ?, ?, ?, ?) ON CONFLICT (session, sequence) DO NOTHING");
  // Batches mostly hold scans of one session, in order.
  const SessionId* session = nullptr;
  std::optional<int64_t> key;
  for (const auto& [id, entry] : entries) {
    if (session == nullptr || *session != id) {
      absl::StatusOr<std::optional<int64_t>> found = FindSessionKey(database, id);
      if (!found.ok()) return found.status();
      if (!*found) return absl::InternalError("a trajectory of an unchecked session");
      key = *found;
      session = &id;
    }
    const absl::Status status = insert.Bind(*key)
                                    .Bind(entry.sequence)
                                    .Bind(entry.stamp_ns)
                                    .Bind(entry.submap_index)
                                    .BindBlob(PackPose(entry.T_odom_sensor))
                                    .Run();
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

TrajectoryEntry ReadTrajectoryEntry(const Statement& row) {
  TrajectoryEntry entry;
  entry.sequence = row.Uint(0);
  entry.stamp_ns = row.Int(1);
  entry.submap_index = row.Uint32(2);
  entry.T_odom_sensor = UnpackPose(row.Text(3));
  return entry;
}

absl::StatusOr<std::vector<TrajectoryEntry>> SelectTrajectory(Connection& database,
                                                              int64_t session_key) {
  Statement rows = database.Prepare(
      "SELECT sequence, stamp_ns, submap_index, T_odom_sensor FROM trajectory "
      "WHERE session = ? ORDER BY sequence");
  return rows.Bind(session_key).ReadAll(ReadTrajectoryEntry);
}

}  // namespace isthmus::storage
