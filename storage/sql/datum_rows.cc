#include "storage/sql/rows.h"

namespace isthmus::storage {

absl::Status SetDatum(Connection& database, const std::optional<Datum>& datum) {
  if (!datum) return database.Prepare("DELETE FROM datum").Run();
  return database
      .Prepare(
          "INSERT INTO datum (id, latitude_deg, longitude_deg, altitude_m, heading_deg, "
          "given_ns) VALUES (1, ?, ?, ?, ?, ?) ON CONFLICT (id) DO UPDATE SET "
          "latitude_deg = excluded.latitude_deg, longitude_deg = excluded.longitude_deg, "
          "altitude_m = excluded.altitude_m, heading_deg = excluded.heading_deg, "
          "given_ns = excluded.given_ns")
      .Bind(datum->latitude_deg)
      .Bind(datum->longitude_deg)
      .Bind(datum->altitude_m)
      .Bind(datum->heading_deg)
      .Bind(datum->given_ns)
      .Run();
}

absl::StatusOr<std::optional<Datum>> SelectDatum(Connection& database) {
  Statement rows = database.Prepare(
      "SELECT latitude_deg, longitude_deg, altitude_m, heading_deg, given_ns FROM datum");
  const auto found = rows.ReadAll([](const Statement& row) {
    return Datum{.latitude_deg = row.Real(0),
                 .longitude_deg = row.Real(1),
                 .altitude_m = row.Real(2),
                 .heading_deg = row.Real(3),
                 .given_ns = row.Int(4)};
  });
  if (!found.ok()) return found.status();
  return found->empty() ? std::optional<Datum>() : found->front();
}

}  // namespace isthmus::storage
