#include "storage/pose_codec.h"
#include "storage/rows.h"

namespace isthmus::storage {
namespace {

absl::Status AddPlacements(Connection& database, const MapRevision& revision) {
  Statement insert = database.Prepare(
      "INSERT INTO placements (revision, session, component, reference, T_map_odom) "
      "VALUES (?, ?, ?, ?, ?)");
  for (const Placement& placement : revision.placements) {
    const absl::Status status = insert.Bind(revision.revision)
                                    .Bind(placement.session.value())
                                    .Bind(placement.component)
                                    .Bind(placement.reference.value())
                                    .BindBlob(PackPose(placement.T_map_odom))
                                    .Run();
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status SelectPlacements(Connection& database, MapRevision& revision) {
  Statement row = database.Prepare(
      "SELECT session, component, reference, T_map_odom FROM placements WHERE revision = ? "
      "ORDER BY session");
  row.Bind(revision.revision);
  while (true) {
    absl::StatusOr<bool> has_row = row.Step();
    if (!has_row.ok()) return has_row.status();
    if (!*has_row) return absl::OkStatus();
    Placement placement;
    placement.session = SessionId(row.Text(0));
    placement.component = static_cast<uint32_t>(row.Int(1));
    placement.reference = SessionId(row.Text(2));
    placement.T_map_odom = UnpackPose(row.Text(3));
    revision.placements.push_back(placement);
  }
}

}  // namespace

absl::Status AddRevision(Connection& database, const MapRevision& revision) {
  absl::Status status =
      database.Prepare("INSERT INTO revisions (revision, stamp_ns, cause) VALUES (?, ?, ?)")
          .Bind(revision.revision)
          .Bind(revision.stamp_ns)
          .Bind(revision.cause)
          .Run();
  if (status.ok()) status = AddPlacements(database, revision);
  if (!status.ok()) return status;
  return database
      .Prepare(
          "DELETE FROM revisions WHERE revision <= (SELECT revision FROM revisions "
          "ORDER BY revision DESC LIMIT 1 OFFSET ?)")
      .Bind(kRevisionsKept)
      .Run();
}

absl::StatusOr<int64_t> LatestRevisionNumber(Connection& database) {
  Statement row = database.Prepare("SELECT coalesce(max(revision), 0) FROM revisions");
  absl::StatusOr<bool> found = row.Step();
  if (!found.ok()) return found.status();
  return row.Int(0);
}

absl::StatusOr<MapRevision> SelectLatestRevision(Connection& database) {
  MapRevision revision;
  Statement row = database.Prepare(
      "SELECT revision, stamp_ns, cause FROM revisions ORDER BY revision DESC LIMIT 1");
  absl::StatusOr<bool> found = row.Step();
  if (!found.ok()) return found.status();
  if (!*found) return revision;
  revision.revision = row.Int(0);
  revision.stamp_ns = row.Int(1);
  revision.cause = row.Text(2);
  if (absl::Status status = SelectPlacements(database, revision); !status.ok()) return status;
  return revision;
}

}  // namespace isthmus::storage
