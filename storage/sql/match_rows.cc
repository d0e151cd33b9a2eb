#include <map>

#include "storage/records/edge_codec.h"
#include "storage/records/pose_codec.h"
#include "storage/sql/rows.h"

namespace isthmus::storage {
namespace {

absl::Status InsertMatch(Connection& database, const KeyPair& keys, const Match& match) {
  Statement insert = database.Prepare(
      "INSERT INTO matches (a, b, T_a_b, state, reason, detail, confidence, overlap, inliers, "
      "residual_m, free_space, comparisons, runner_up, matcher, submaps_a, submaps_b, computed_ns, "
      "inlier_ratio, shared_area_m2, hold, strain, candidates, edges) "
      "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  insert.Bind(keys.first)
      .Bind(keys.second)
      .BindBlob(PackPose(match.T_a_b))
      .Bind(std::string(ToString(match.state)))
      .Bind(std::string(ToString(match.reason)))
      .Bind(match.detail)
      .Bind(match.confidence)
      .Bind(match.overlap)
      .Bind(match.inliers)
      .Bind(match.residual_m)
      .Bind(match.free_space)
      .Bind(match.comparisons)
      .Bind(match.runner_up)
      .Bind(std::string(ToString(match.matcher)))
      .Bind(match.submaps_a)
      .Bind(match.submaps_b)
      .Bind(match.computed_ns)
      .Bind(match.inlier_ratio)
      .Bind(match.shared_area_m2)
      .Bind(match.observability)
      .Bind(match.odometry_residual)
      .Bind(match.candidates);
  if (match.edges.empty()) return insert.BindNull().Run();
  return insert.BindBlob(EncodeEdges(match.edges)).Run();
}

absl::Status InsertStages(Connection& database, const KeyPair& keys, const Match& match) {
  Statement insert = database.Prepare(
      "INSERT INTO match_stages (a, b, position, stage, ms) VALUES (?, ?, ?, ?, ?)");
  int position = 0;
  for (const StageTime& stage : match.stages) {
    insert.Bind(keys.first).Bind(keys.second).Bind(position++).Bind(stage.stage).Bind(stage.ms);
    if (absl::Status status = insert.Run(); !status.ok()) return status;
  }
  return absl::OkStatus();
}

Match ReadMatch(const Statement& row) {
  Match match;
  match.a = SessionId(row.Text(2));
  match.b = SessionId(row.Text(3));
  match.T_a_b = UnpackPose(row.Text(4));
  match.state = ParseState(row.Text(5));
  match.reason = ParseMatchReason(row.Text(6));
  match.detail = row.Text(7);
  match.confidence = row.Real(8);
  match.overlap = row.Real(9);
  match.inliers = row.Int(10);
  match.residual_m = row.Real(11);
  match.free_space = row.Real(12);
  match.comparisons = row.Int(13);
  match.runner_up = row.Real(14);
  match.matcher = ParseGuessSource(row.Text(15));
  match.submaps_a = row.Uint32(16);
  match.submaps_b = row.Uint32(17);
  match.computed_ns = row.Int(18);
  match.inlier_ratio = row.Real(19);
  match.shared_area_m2 = row.Real(20);
  match.observability = row.Real(21);
  match.odometry_residual = row.Real(22);
  match.candidates = row.Uint32(23);
  // Still a match without them, and no reason to keep all the others from being served.
  if (!row.IsNull(24) && !DecodeEdges(row.Text(24), match.edges).ok()) match.edges.clear();
  return match;
}

absl::StatusOr<std::map<KeyPair, std::vector<StageTime>>> SelectStages(Connection& database) {
  std::map<KeyPair, std::vector<StageTime>> stages;
  Statement row =
      database.Prepare("SELECT a, b, stage, ms FROM match_stages ORDER BY a, b, position");
  while (true) {
    absl::StatusOr<bool> has_row = row.Step();
    if (!has_row.ok()) return has_row.status();
    if (!*has_row) return stages;
    stages[{row.Int(0), row.Int(1)}].push_back({row.Text(2), row.Real(3)});
  }
}

}  // namespace

// Names are stored, so that the numbers of the enumeration may change.
MatchState ParseState(const std::string& name) {
  for (const MatchState state :
       {MatchState::kAccepted, MatchState::kRejected, MatchState::kAmbiguous}) {
    if (name == ToString(state)) return state;
  }
  return MatchState::kNotYet;
}

absl::Status PutMatch(Connection& database, const Match& match) {
  absl::StatusOr<std::optional<int64_t>> a = FindSessionKey(database, match.a);
  if (!a.ok()) return a.status();
  absl::StatusOr<std::optional<int64_t>> b = FindSessionKey(database, match.b);
  if (!b.ok()) return b.status();
  if (!*a || !*b) return absl::InternalError("a match of unchecked sessions");
  const KeyPair keys(**a, **b);
  // Deleted rather than updated: its stages and rivals go along.
  absl::Status status = database.Prepare("DELETE FROM matches WHERE a = ? AND b = ?")
                            .Bind(keys.first)
                            .Bind(keys.second)
                            .Run();
  if (status.ok()) status = InsertMatch(database, keys, match);
  if (status.ok()) status = InsertStages(database, keys, match);
  if (status.ok()) status = InsertRivals(database, keys, match.rivals);
  return status;
}

absl::StatusOr<std::vector<Match>> SelectMatches(Connection& database) {
  auto stages = SelectStages(database);
  if (!stages.ok()) return stages.status();
  auto rivals = SelectRivals(database);
  if (!rivals.ok()) return rivals.status();
  Statement rows = database.Prepare(
      "SELECT m.a, m.b, a.id, b.id, T_a_b, m.state, reason, detail, confidence, overlap, inliers, "
      "residual_m, free_space, comparisons, runner_up, matcher, submaps_a, submaps_b, computed_ns, "
      "inlier_ratio, shared_area_m2, hold, strain, candidates, edges FROM matches m JOIN sessions "
      "a ON a.key = m.a JOIN sessions b ON b.key = m.b "
      "ORDER BY a.id, b.id");
  return rows.ReadAll([&](const Statement& row) {
    Match match = ReadMatch(row);
    match.stages = std::move((*stages)[{row.Int(0), row.Int(1)}]);
    match.rivals = std::move((*rivals)[{row.Int(0), row.Int(1)}]);
    return match;
  });
}

}  // namespace isthmus::storage
