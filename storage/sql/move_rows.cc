#include "storage/records/pose_codec.h"
#include "storage/sql/rows.h"

namespace isthmus::storage {
namespace {

Statement& BindPose(Statement& statement, const std::optional<Pose>& pose) {
  return pose ? statement.BindBlob(PackPose(*pose)) : statement.BindNull();
}

std::optional<Pose> ReadOptionalPose(const Statement& row, int column) {
  if (row.IsNull(column)) return std::nullopt;
  return UnpackPose(row.Text(column));
}

}  // namespace

absl::Status AddMoves(Connection& database, int64_t revision,
                      const std::vector<SubmapMove>& moves) {
  Statement insert = database.Prepare(
      "INSERT INTO submap_moves (revision, session, submap_index, T_before, frame_before, T_after, "
      "frame_after) VALUES (?, ?, ?, ?, ?, ?, ?)");
  Statement place = database.Prepare(
      "INSERT INTO placed_submaps (session, submap_index, T_map_submap) VALUES (?, ?, ?) "
      "ON CONFLICT (session, submap_index) DO UPDATE SET T_map_submap = excluded.T_map_submap");
  Statement remove =
      database.Prepare("DELETE FROM placed_submaps WHERE session = ? AND submap_index = ?");
  for (const SubmapMove& move : moves) {
    insert.Bind(revision).Bind(move.submap.session.value()).Bind(move.submap.index);
    BindPose(insert, move.before).Bind(move.frame_before.value());
    BindPose(insert, move.after).Bind(move.frame_after.value());
    if (absl::Status status = insert.Run(); !status.ok()) return status;
    Statement& change = move.after ? place : remove;
    change.Bind(move.submap.session.value()).Bind(move.submap.index);
    if (move.after) BindPose(change, move.after);
    if (absl::Status status = change.Run(); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::pair<int64_t, SubmapMove>>> SelectMoves(Connection& database,
                                                                        int64_t from, int64_t to) {
  Statement rows = database.Prepare(
      "SELECT revision, session, submap_index, T_before, frame_before, T_after, frame_after "
      "FROM submap_moves WHERE revision > ? AND revision <= ? "
      "ORDER BY revision, session, submap_index");
  return rows.Bind(from).Bind(to).ReadAll([](const Statement& row) {
    SubmapMove move;
    move.submap = {SessionId(row.Text(1)), row.Uint32(2)};
    move.before = ReadOptionalPose(row, 3);
    move.frame_before = SessionId(row.Text(4));
    move.after = ReadOptionalPose(row, 5);
    move.frame_after = SessionId(row.Text(6));
    return std::pair(row.Int(0), std::move(move));
  });
}

absl::StatusOr<std::vector<SubmapPose>> SelectPlacedSubmaps(Connection& database,
                                                            const SessionId& session) {
  Statement rows = database.Prepare(
      "SELECT submap_index, T_map_submap FROM placed_submaps WHERE session = ? "
      "ORDER BY submap_index");
  return rows.Bind(session.value()).ReadAll([](const Statement& row) {
    return SubmapPose{row.Uint32(0), UnpackPose(row.Text(1))};
  });
}

}  // namespace isthmus::storage
