#include <absl/strings/str_cat.h>

#include "core/io/crc32c.h"
#include "storage/batch_rules.h"
#include "storage/sql/rows.h"

namespace isthmus::storage {

absl::Status PutFeatureRow(Connection& database, const FeatureBlob& blob) {
  absl::StatusOr<std::optional<int64_t>> submap = FindSubmapKey(database, blob.submap);
  if (!submap.ok()) return submap.status();
  if (!*submap) return UnknownSubmap(blob.submap);
  return database
      .Prepare(
          "INSERT INTO features (submap, kind, crc32c, data) VALUES (?, ?, ?, ?) "
          "ON CONFLICT (submap, kind) DO UPDATE SET crc32c = excluded.crc32c, "
          "data = excluded.data")
      .Bind(**submap)
      .Bind(blob.kind)
      .Bind(io::Crc32c(blob.data.data(), blob.data.size()))
      .BindBlob(blob.data)
      .Run();
}

absl::StatusOr<std::string> FindFeatures(Connection& database, const SubmapId& submap,
                                         const std::string& kind) {
  absl::StatusOr<std::optional<int64_t>> key = FindSubmapKey(database, submap);
  if (!key.ok()) return key.status();
  if (!*key) return UnknownSubmap(submap);
  Statement row =
      database.Prepare("SELECT crc32c, data FROM features WHERE submap = ? AND kind = ?");
  absl::StatusOr<bool> found = row.Bind(**key).Bind(kind).Step();
  if (!found.ok()) return found.status();
  if (!*found) return NoFeatures(submap, kind);
  std::string data = row.Text(1);
  if (io::Crc32c(data.data(), data.size()) == row.Uint(0)) return data;
  return absl::DataLossError(absl::StrCat("the features '", kind, "' of submap ", ToString(submap),
                                          " are damaged: their checksum is wrong"));
}

}  // namespace isthmus::storage
