#include "storage/records/pose_codec.h"
#include "storage/sql/rows.h"

namespace isthmus::storage {

absl::Status PutAnchor(Connection& database, const Anchor& anchor) {
  absl::StatusOr<std::optional<int64_t>> submap = FindSubmapKey(database, anchor.submap);
  if (!submap.ok()) return submap.status();
  if (!*submap) return absl::InternalError("an anchor of an unchecked submap");
  return database
      .Prepare(
          "INSERT INTO anchors (submap, T_map_submap, sigma_xy_m, sigma_z_m, sigma_deg, "
          "note, given_ns) VALUES (?, ?, ?, ?, ?, ?, ?) ON CONFLICT (submap) DO UPDATE SET "
          "T_map_submap = excluded.T_map_submap, sigma_xy_m = excluded.sigma_xy_m, "
          "sigma_z_m = excluded.sigma_z_m, sigma_deg = excluded.sigma_deg, note = excluded.note, "
          "given_ns = excluded.given_ns")
      .Bind(**submap)
      .BindBlob(PackPose(anchor.T_map_submap))
      .Bind(anchor.sigma_xy_m)
      .Bind(anchor.sigma_z_m)
      .Bind(anchor.sigma_deg)
      .Bind(anchor.note)
      .Bind(anchor.given_ns)
      .Run();
}

absl::Status RemoveAnchor(Connection& database, const SubmapId& submap) {
  absl::StatusOr<std::optional<int64_t>> key = FindSubmapKey(database, submap);
  if (!key.ok()) return key.status();
  if (!*key) return absl::OkStatus();
  return database.Prepare("DELETE FROM anchors WHERE submap = ?").Bind(**key).Run();
}

absl::StatusOr<std::vector<Anchor>> SelectAnchors(Connection& database) {
  Statement rows = database.Prepare(
      "SELECT e.id, s.submap_index, T_map_submap, sigma_xy_m, sigma_z_m, sigma_deg, a.note, "
      "given_ns FROM anchors a JOIN submaps s ON s.key = a.submap "
      "JOIN sessions e ON e.key = s.session ORDER BY e.id, s.submap_index");
  return rows.ReadAll([](const Statement& row) {
    return Anchor{.submap = {SessionId(row.Text(0)), row.Uint32(1)},
                  .T_map_submap = UnpackPose(row.Text(2)),
                  .sigma_xy_m = row.Real(3),
                  .sigma_z_m = row.Real(4),
                  .sigma_deg = row.Real(5),
                  .note = row.Text(6),
                  .given_ns = row.Int(7)};
  });
}

}  // namespace isthmus::storage
