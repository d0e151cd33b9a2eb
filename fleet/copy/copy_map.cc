#include "fleet/copy/copy_map.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <bit>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "core/io/crc32c.h"
#include "core/io/directory_lock.h"
#include "core/io/folder.h"
#include "fleet/postgresql/migrations.h"
#include "fleet/postgresql/postgres_store.h"
#include "fleet/postgresql/site_bucket.h"
#include "fleet/postgresql/site_lease.h"
#include "fleet/postgresql/site_writer.h"
#include "storage/sql/rows.h"
#include "storage/sqlite/migrations.h"
#include "storage/sqlite/open_marker.h"
#include "storage/sqlite/tables.h"

namespace isthmus::storage {
namespace {

using Kind = TableColumn::Kind;

// A database that nobody else uses meanwhile.
struct OpenPlace {
  std::string made = {};                    // Folder of a database that was not there before.
  std::unique_ptr<io::DirectoryLock> lock;  // The folder's; goes last.
  std::unique_ptr<SiteLease> lease;         // The site's; goes last but one.
  std::unique_ptr<Connection> database;
  std::unique_ptr<LargeValues> large_values;  // Null where rows have them.
  int64_t schema = 0;
};

bool IsDatabase(const MapPlace& place) {
  return absl::StartsWith(place.where, "postgresql://") ||
         absl::StartsWith(place.where, "postgres://");
}

absl::StatusOr<OpenPlace> OpenSite(const MapPlace& place) {
  if (absl::Status status = CheckSite(place.site); !status.ok()) return status;
  const PostgresTarget target{place.where, SchemaOfSite(place.site), "isthmus copy", true};
  auto lease = SiteLease::Take(target, {});
  if (!lease.ok()) return lease.status();
  auto writer = SiteWriter::Open(target, (*lease)->epoch(), nullptr);
  if (!writer.ok()) return writer.status();
  auto large_values = OpenOwnersBucket(**writer, place.bucket, target.schema);
  if (!large_values.ok()) return large_values.status();
  return OpenPlace{"",
                   nullptr,
                   *std::move(lease),
                   *std::move(writer),
                   *std::move(large_values),
                   PostgresMigrations().back().version};
}

// NotFound where there is no such site: to look is not to make one.
absl::Status ExpectSite(const MapPlace& place) {
  if (absl::Status status = CheckSite(place.site); !status.ok()) return status;
  const std::string schema = SchemaOfSite(place.site);
  auto database = PostgresConnection::Open({place.where, schema, "isthmus copy", true});
  if (!database.ok()) return database.status();
  const absl::StatusOr<bool> found =
      (*database)->Prepare("SELECT 1 FROM pg_namespace WHERE nspname = ?").Bind(schema).Step();
  if (!found.ok() || *found) return found.status();
  return absl::NotFoundError(absl::StrCat("there is no map: the database has no schema ", schema));
}

absl::StatusOr<OpenPlace> OpenSource(const MapPlace& place) {
  if (IsDatabase(place)) {
    if (absl::Status status = ExpectSite(place); !status.ok()) return status;
    return OpenSite(place);
  }
  const std::string path = place.where + "/isthmus.db";
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    return absl::NotFoundError(absl::StrCat("there is no map: ", path, " does not exist"));
  }
  OpenPlace open;
  auto lock = io::DirectoryLock::TakeExisting(place.where);
  if (!lock.ok()) return lock.status();
  open.lock = *std::move(lock);
  if (const std::string missing = MissingLog(place.where); !missing.empty()) {
    return absl::DataLossError(missing);
  }
  auto database = SqliteConnection::Open(path, SqliteConnection::Access::kReadOnly);
  if (!database.ok()) return database.status();
  if (auto status = CheckSchema(**database); !status.ok()) return status;
  const auto schema = (*database)->ReadNumber("PRAGMA user_version");
  if (!schema.ok()) return schema.status();
  open.schema = *schema;
  open.database = *std::move(database);
  if (open.schema == Migrations().back().version) return open;
  return absl::FailedPreconditionError(
      absl::StrCat(place.where, " has the older schema ", open.schema,
                   ": start isthmus-server on it once, which brings it to the newest"));
}

void RemovePartial(const std::string& directory) {
  std::error_code ignored;
  for (const char* ending : {"", "-journal"}) {
    std::filesystem::remove(PartialDatabase(directory) + ending, ignored);
  }
}

absl::StatusOr<OpenPlace> OpenTarget(const MapPlace& place) {
  if (IsDatabase(place)) return OpenSite(place);
  if (!place.bucket.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "a bucket is for the large values of a map in a database, not in ", place.where));
  }
  std::error_code error;
  std::filesystem::create_directories(place.where, error);
  OpenPlace open;
  auto lock = io::DirectoryLock::Acquire(place.where);
  if (!lock.ok()) return lock.status();
  open.lock = *std::move(lock);
  std::string path = place.where + "/isthmus.db";
  if (!std::filesystem::exists(path, error)) {
    open.made = place.where;
    path = PartialDatabase(place.where);
    RemovePartial(place.where);  // The rest of an earlier copy.
  }
  auto database = SqliteConnection::Open(path);
  if (!database.ok()) return database.status();
  absl::Status status = CheckSchema(**database);
  if (status.ok()) {
    status = (*database)->Execute("PRAGMA foreign_keys = ON; PRAGMA synchronous = FULL");
  }
  if (status.ok()) status = Migrate(**database);
  if (!status.ok()) return status;
  open.schema = Migrations().back().version;
  open.database = *std::move(database);
  return open;
}

struct Value {
  bool is_null = false;
  int64_t number = 0;
  double real = 0;
  std::string bytes = {};  // For texts and blobs.
};
using Row = std::vector<Value>;

Row ReadRow(const Statement& statement, const Table& table) {
  Row row(table.columns.size());
  for (size_t i = 0; i < row.size(); ++i) {
    const int column = static_cast<int>(i);
    row[i].is_null = statement.IsNull(column);
    if (row[i].is_null) continue;
    switch (table.columns[i].kind) {
      case Kind::kNumber:
        row[i].number = statement.Int(column);
        break;
      case Kind::kReal:
        row[i].real = statement.Real(column);
        break;
      case Kind::kText:
      case Kind::kBlob:
        row[i].bytes = statement.Text(column);
        break;
    }
  }
  return row;
}

void BindValue(const Value& value, Kind kind, Statement& statement) {
  if (value.is_null) {
    statement.BindNull();
  } else if (kind == Kind::kNumber) {
    statement.Bind(value.number);
  } else if (kind == Kind::kReal) {
    statement.Bind(value.real);
  } else if (kind == Kind::kText) {
    statement.Bind(value.bytes);
  } else {
    statement.BindBlob(value.bytes);
  }
}

// Count and checksum of rows, in their order, as far as they were added.
struct Sum {
  int64_t rows = 0;
  uint32_t crc32c = 0;

  void Add(const Row& row) {
    ++rows;
    std::string bytes;
    const auto add = [&bytes](uint64_t number) {
      bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
    };
    add(crc32c);
    for (const Value& value : row) {
      add(value.is_null ? 1 : 0);
      add(static_cast<uint64_t>(value.number));
      add(std::bit_cast<uint64_t>(value.real));
      add(value.bytes.size());
      bytes += value.bytes;
    }
    crc32c = io::Crc32c(bytes.data(), bytes.size());
  }
  bool operator==(const Sum&) const = default;
};

std::string Names(const Table& table, size_t count) {
  return absl::StrJoin(table.columns.begin(), table.columns.begin() + static_cast<long>(count),
                       ", ", [](std::string* out, const TableColumn& c) { out->append(c.name); });
}

std::string Marks(size_t count) {
  return absl::StrJoin(std::vector<std::string>(count, "?"), ", ");
}

// Calls `visit` for every row, in order of the key, a page at a time: none holds all of a table.
template <typename Visit>
absl::Status ForEachRowOf(Connection& database, const Table& table, const Visit& visit) {
  const int page_size = table.has_blobs ? 16 : 2000;
  const std::string keys = Names(table, table.keys);
  const std::string select =
      absl::StrCat("SELECT ", Names(table, table.columns.size()), " FROM ", table.name);
  const std::string order = absl::StrCat(" ORDER BY ", keys, " LIMIT ", page_size);
  std::optional<Row> last;
  while (true) {
    std::string sql = select;
    if (last) absl::StrAppend(&sql, " WHERE (", keys, ") > (", Marks(table.keys), ")");
    Statement statement = database.Prepare(sql + order);
    for (size_t i = 0; last && i < table.keys; ++i) {
      BindValue((*last)[i], table.columns[i].kind, statement);
    }
    const auto page = statement.ReadAll([&](const Statement& row) { return ReadRow(row, table); });
    if (!page.ok()) return page.status();
    for (const Row& row : *page) {
      if (absl::Status status = visit(row); !status.ok()) return status;
    }
    if (page->size() < static_cast<size_t>(page_size)) return absl::OkStatus();
    last = page->back();
  }
}

// The row as `to` has it: a value in a bucket is fetched, and goes into the bucket of `to`, if any.
// The checksums of rows are of their own contents.
absl::Status MoveLargeValues(const OpenPlace& from, const OpenPlace& to, const Table& table,
                             Row* row) {
  if (!table.has_blobs) return absl::OkStatus();
  for (size_t i = 0; i < row->size(); ++i) {
    if (table.columns[i].kind != Kind::kBlob) continue;
    absl::StatusOr<std::string> value = (*row)[i].bytes;
    if (from.large_values) value = from.large_values->Get(*std::move(value));
    if (value.ok() && to.large_values) value = to.large_values->Put(*std::move(value));
    if (!value.ok()) return value.status();
    if (*value == (*row)[i].bytes) continue;  // With its checksum, right or wrong.
    for (size_t k = 0; k < row->size(); ++k) {
      if (table.columns[k].name != "crc32c") continue;
      (*row)[k].number = io::Crc32c(value->data(), value->size());
    }
    (*row)[i].bytes = *std::move(value);
  }
  return absl::OkStatus();
}

absl::Status CopyTable(const OpenPlace& source, const OpenPlace& target, const Table& table,
                       int64_t* records) {
  Connection &from = *source.database, &to = *target.database;
  Sum sent, found;
  const std::string insert =
      absl::StrCat("INSERT INTO ", table.name, " (", Names(table, table.columns.size()),
                   ") VALUES (", Marks(table.columns.size()), ")");
  absl::Status status = ForEachRowOf(from, table, [&](Row row) {
    absl::Status moved = MoveLargeValues(source, target, table, &row);
    if (!moved.ok()) return moved;
    Statement statement = to.Prepare(insert);
    for (size_t i = 0; i < row.size(); ++i) BindValue(row[i], table.columns[i].kind, statement);
    sent.Add(row);
    ++*records;
    return statement.Run();
  });
  if (!status.ok()) {
    return absl::Status(status.code(), absl::StrCat("table ", table.name, ": ", status.message()));
  }
  status = ForEachRowOf(to, table, [&found](const Row& row) {
    found.Add(row);
    return absl::OkStatus();
  });
  if (!status.ok() || found == sent) return status;
  return absl::DataLossError(absl::StrCat("table ", table.name, ": ", sent.rows,
                                          " records were written and ", found.rows,
                                          " read back, or others: nothing was kept"));
}

// Keys that the database counts go on behind those that are there.
absl::Status CountOn(Connection& database, const Table& table) {
  return database
      .Prepare(absl::StrCat("SELECT setval(pg_get_serial_sequence('", table.name,
                            "', 'key'), (SELECT coalesce(max(key), 0) + 1 FROM ", table.name,
                            "), false)"))
      .Step()
      .status();
}

absl::Status ExpectNoMap(Connection& database, const std::vector<Table>& tables,
                         const MapPlace& place) {
  for (const Table& table : tables) {
    const auto rows = database.ReadNumber(absl::StrCat("SELECT count(*) FROM ", table.name));
    if (!rows.ok()) return rows.status();
    if (*rows == 0) continue;
    return absl::AlreadyExistsError(
        absl::StrCat(place.where, " has a map already; name a place without one"));
  }
  return absl::OkStatus();
}

absl::Status CopyTables(const OpenPlace& from, const OpenPlace& to,
                        const std::vector<Table>& tables, bool is_database, CopyReport* report) {
  for (const Table& table : tables) {
    const int64_t before = report->records;
    absl::Status status = CopyTable(from, to, table, &report->records);
    if (status.ok() && is_database && table.counts_keys) status = CountOn(*to.database, table);
    if (!status.ok()) return status;
    const int64_t count = report->records - before;
    if (table.name == "sessions") report->sessions = count;
    if (table.name == "trajectory") report->scans = count;
    if (table.name == "submaps") report->submaps = count;
    if (table.name == "matches") report->matches = count;
    if (table.name == "revisions") report->revisions = count;
    if (table.name == "events") report->events = count;
  }
  return absl::OkStatus();
}

absl::StatusOr<CopyReport> CopyAll(const OpenPlace& source, const OpenPlace& target,
                                   const MapPlace& to) {
  const absl::StatusOr<std::vector<Table>> tables = MapTables();
  if (!tables.ok()) return tables.status();
  const Transaction snapshot(*source.database, Transaction::Kind::kRead);
  if (!snapshot.status().ok()) return snapshot.status();
  Transaction transaction(*target.database);
  absl::Status status = transaction.status();
  if (status.ok()) status = ExpectNoMap(*target.database, *tables, to);
  CopyReport report;
  report.schema = source.schema;
  if (status.ok()) status = CopyTables(source, target, *tables, IsDatabase(to), &report);
  if (status.ok()) status = transaction.Commit();
  if (!status.ok()) return status;
  return report;
}

// The whole copy becomes the folder's map.
absl::Status Finish(const std::string& directory) {
  const std::string path = directory + "/isthmus.db";
  std::error_code error;
  std::filesystem::rename(PartialDatabase(directory), path, error);
  if (error) return io::FileError("write", path, error.value());
  return io::SyncFolder(directory);
}

}  // namespace

absl::StatusOr<CopyReport> CopyMap(const MapPlace& from, const MapPlace& to) {
  absl::StatusOr<OpenPlace> source = OpenSource(from);
  if (!source.ok()) return source.status();
  absl::StatusOr<OpenPlace> target = OpenTarget(to);
  if (!target.ok()) return target.status();
  if (source->schema != target->schema) {
    return absl::InternalError("the two databases have schemas of different numbers");
  }
  const auto report = CopyAll(*source, *target, to);
  if (target->made.empty()) return report;
  target->database = nullptr;
  // Tables without a map would be served as one.
  absl::Status status = report.status();
  if (status.ok()) status = Finish(target->made);
  if (!status.ok()) RemovePartial(target->made);
  if (!status.ok()) return status;
  return report;
}

}  // namespace isthmus::storage
