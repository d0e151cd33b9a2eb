#include "storage/records/pose_codec.h"
#include "storage/sql/rows.h"

namespace isthmus::storage {
namespace {

using KeyPair = std::pair<int64_t, int64_t>;

// Names are stored, so that the numbers of the enumeration may change.
ManualDecisionKind ParseManualDecisionKind(const std::string& name) {
  for (const ManualDecisionKind kind : {ManualDecisionKind::kAccept, ManualDecisionKind::kSet}) {
    if (name == ToString(kind)) return kind;
  }
  return ManualDecisionKind::kReject;  // An unknown kind joins nothing.
}

absl::StatusOr<std::optional<KeyPair>> FindKeys(Connection& database, const SessionId& a,
                                                const SessionId& b) {
  absl::StatusOr<std::optional<int64_t>> key_a = FindSessionKey(database, a);
  if (!key_a.ok()) return key_a.status();
  absl::StatusOr<std::optional<int64_t>> key_b = FindSessionKey(database, b);
  if (!key_b.ok()) return key_b.status();
  if (!*key_a || !*key_b) return std::nullopt;
  return KeyPair(**key_a, **key_b);
}

}  // namespace

absl::Status PutManualDecision(Connection& database, const ManualDecision& manual_decision) {
  const auto keys = FindKeys(database, manual_decision.a, manual_decision.b);
  if (!keys.ok()) return keys.status();
  if (!*keys) return absl::InternalError("a manual decision on unchecked sessions");
  return database
      .Prepare(
          "INSERT INTO verdicts (a, b, ruling, T_a_b, note, given_ns) "
          "VALUES (?, ?, ?, ?, ?, ?) ON CONFLICT (a, b) DO UPDATE SET ruling = excluded.ruling, "
          "T_a_b = excluded.T_a_b, note = excluded.note, given_ns = excluded.given_ns")
      .Bind((*keys)->first)
      .Bind((*keys)->second)
      .Bind(std::string(ToString(manual_decision.kind)))
      .BindBlob(PackPose(manual_decision.T_a_b))
      .Bind(manual_decision.note)
      .Bind(manual_decision.given_ns)
      .Run();
}

absl::Status RemoveManualDecision(Connection& database, const SessionId& a, const SessionId& b) {
  const auto keys = FindKeys(database, a, b);
  if (!keys.ok()) return keys.status();
  if (!*keys) return absl::OkStatus();
  return database.Prepare("DELETE FROM verdicts WHERE a = ? AND b = ?")
      .Bind((*keys)->first)
      .Bind((*keys)->second)
      .Run();
}

absl::StatusOr<std::vector<ManualDecision>> SelectManualDecisions(Connection& database) {
  Statement rows = database.Prepare(
      "SELECT a.id, b.id, ruling, T_a_b, v.note, given_ns FROM verdicts v "
      "JOIN sessions a ON a.key = v.a JOIN sessions b ON b.key = v.b ORDER BY a.id, b.id");
  return rows.ReadAll([](const Statement& row) {
    return ManualDecision{SessionId(row.Text(0)),
                          SessionId(row.Text(1)),
                          ParseManualDecisionKind(row.Text(2)),
                          UnpackPose(row.Text(3)),
                          row.Text(4),
                          row.Int(5)};
  });
}

}  // namespace isthmus::storage
