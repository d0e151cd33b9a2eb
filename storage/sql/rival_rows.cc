#include "storage/records/edge_codec.h"
#include "storage/records/pose_codec.h"
#include "storage/sql/rows.h"

namespace isthmus::storage {

absl::Status InsertRivals(Connection& database, const KeyPair& keys,
                          const std::vector<RivalMatch>& rivals) {
  Statement insert = database.Prepare(
      "INSERT INTO match_rivals (a, b, position, T_a_b, state, reason, confidence, matcher, "
      "overlap, free_space, comparisons, shared_area_m2, edges) "
      "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  int position = 0;
  for (const RivalMatch& rival : rivals) {
    insert.Bind(keys.first)
        .Bind(keys.second)
        .Bind(position++)
        .BindBlob(PackPose(rival.T_a_b))
        .Bind(std::string(ToString(rival.state)))
        .Bind(std::string(ToString(rival.reason)))
        .Bind(rival.confidence)
        .Bind(std::string(ToString(rival.matcher)))
        .Bind(rival.overlap)
        .Bind(rival.free_space)
        .Bind(rival.comparisons)
        .Bind(rival.shared_area_m2);
    if (rival.edges.empty()) {
      insert.BindNull();
    } else {
      insert.BindBlob(EncodeEdges(rival.edges));
    }
    if (absl::Status status = insert.Run(); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<std::map<KeyPair, std::vector<RivalMatch>>> SelectRivals(Connection& database) {
  std::map<KeyPair, std::vector<RivalMatch>> rivals;
  Statement row = database.Prepare(
      "SELECT a, b, T_a_b, state, reason, confidence, matcher, overlap, free_space, comparisons, "
      "shared_area_m2, edges FROM match_rivals ORDER BY a, b, position");
  while (true) {
    absl::StatusOr<bool> has_row = row.Step();
    if (!has_row.ok()) return has_row.status();
    if (!*has_row) return rivals;
    RivalMatch& rival = rivals[{row.Int(0), row.Int(1)}].emplace_back();
    rival.T_a_b = UnpackPose(row.Text(2));
    rival.state = ParseState(row.Text(3));
    rival.reason = ParseMatchReason(row.Text(4));
    rival.confidence = row.Real(5);
    rival.matcher = ParseGuessSource(row.Text(6));
    rival.overlap = row.Real(7);
    rival.free_space = row.Real(8);
    rival.comparisons = row.Int(9);
    rival.shared_area_m2 = row.Real(10);
    // As of matches: no reason to keep others from being served.
    if (!row.IsNull(11) && !DecodeEdges(row.Text(11), rival.edges).ok()) rival.edges.clear();
  }
}

}  // namespace isthmus::storage
