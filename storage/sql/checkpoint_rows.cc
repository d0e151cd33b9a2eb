#include "core/io/crc32c.h"
#include "storage/sql/rows.h"

namespace isthmus::storage {

absl::Status PutCheckpoint(Connection& database, const Checkpoint& checkpoint) {
  absl::StatusOr<std::optional<int64_t>> session = FindSessionKey(database, checkpoint.session);
  if (!session.ok()) return session.status();
  const std::string& data = checkpoint.data.value();  // CheckBatch has seen that it is there.
  return database
      .Prepare(
          "INSERT INTO checkpoints (session, sequence, durable_sequence, crc32c, data) "
          "VALUES (?, ?, ?, ?, ?) ON CONFLICT (session) DO UPDATE SET "
          "sequence = excluded.sequence, durable_sequence = excluded.durable_sequence, "
          "crc32c = excluded.crc32c, data = excluded.data")
      .Bind(session->value())
      .Bind(checkpoint.sequence)
      .Bind(checkpoint.durable_sequence)
      .Bind(io::Crc32c(data.data(), data.size()))
      .BindBlob(data)
      .Run();
}

absl::Status RemoveCheckpoint(Connection& database, const SessionId& session) {
  return database
      .Prepare("DELETE FROM checkpoints WHERE session = (SELECT key FROM sessions WHERE id = ?)")
      .Bind(session.value())
      .Run();
}

absl::StatusOr<std::optional<Checkpoint>> FindCheckpoint(Connection& database,
                                                         int64_t session_key) {
  // The data apart: where its pages cannot be read the numbers still can.
  Statement row = database.Prepare(
      "SELECT sequence, durable_sequence, crc32c FROM checkpoints WHERE session = ?");
  absl::StatusOr<bool> found = row.Bind(session_key).Step();
  if (!found.ok()) return found.status();
  if (!*found) return std::nullopt;
  Checkpoint checkpoint;
  checkpoint.sequence = row.Uint(0);
  checkpoint.durable_sequence = row.Uint(1);
  Statement blob = database.Prepare("SELECT data FROM checkpoints WHERE session = ?");
  const absl::StatusOr<bool> read = blob.Bind(session_key).Step();
  if (!read.ok() || !*read) return checkpoint;
  std::string data = blob.Text(0);
  if (io::Crc32c(data.data(), data.size()) == row.Uint(2)) checkpoint.data = std::move(data);
  return checkpoint;
}

}  // namespace isthmus::storage
