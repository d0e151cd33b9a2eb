#include "fleet/postgresql/site_bucket.h"

#include <absl/strings/escaping.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/io/secret.h"
#include "fleet/objects/s3_bucket.h"

namespace isthmus::storage {
namespace {

// As those of jobs, the tables belong to no version of the schema: most sites have none.
constexpr char kBucketTables[] = R"(
CREATE TABLE IF NOT EXISTS bucket (
  id BIGINT PRIMARY KEY CHECK (id = 1),
  url TEXT COLLATE "C" NOT NULL,
  folder TEXT COLLATE "C" NOT NULL
);
CREATE TABLE IF NOT EXISTS unreferenced_objects (
  name TEXT COLLATE "C" PRIMARY KEY,
  since TIMESTAMPTZ NOT NULL
)
)";

struct Place {
  std::string url, folder;
};

absl::StatusOr<std::optional<Place>> FindPlace(Connection& database) {
  const auto is_there =
      database.ReadNumber("SELECT (to_regclass('bucket') IS NOT NULL)::int::bigint");
  if (!is_there.ok()) return is_there.status();
  if (*is_there == 0) return std::nullopt;
  Statement row = database.Prepare("SELECT url, folder FROM bucket");
  const absl::StatusOr<bool> found = row.Step();
  if (!found.ok()) return found.status();
  if (!*found) return std::nullopt;
  return Place{row.Text(0), row.Text(1)};
}

absl::StatusOr<std::unique_ptr<LargeValues>> OpenAt(const Place& place,
                                                    size_t smallest = kSmallestObject) {
  auto bucket = S3Bucket::Open(place.url);
  if (!bucket.ok()) return bucket.status();
  return std::make_unique<LargeValues>(*std::move(bucket), place.folder, smallest);
}

absl::Status NotePlace(Connection& writer, const Place& place) {
  Transaction transaction(writer);
  if (!transaction.status().ok()) return transaction.status();
  absl::Status status = writer.Execute(kBucketTables);
  if (status.ok()) {
    status = writer.Prepare("INSERT INTO bucket (id, url, folder) VALUES (1, ?, ?)")
                 .Bind(place.url)
                 .Bind(place.folder)
                 .Run();
  }
  return status.ok() ? transaction.Commit() : status;
}

// The owner must not depend on names alone: two databases may have a site of one name.
absl::StatusOr<Place> NewPlace(const std::string& url, const std::string& schema) {
  const absl::StatusOr<std::string> random = io::RandomBytes(8);
  if (!random.ok()) return random.status();
  return Place{url, absl::StrCat(schema, "-", absl::BytesToHexString(*random), "/")};
}

absl::StatusOr<std::set<std::string>> ReadReferenced(Connection& database) {
  std::set<std::string> names;
  for (const char* table : {"submap_blobs", "features", "checkpoints"}) {
    const auto read = [&names](const Statement& row) {
      if (auto object = FindReference(row.Text(0))) names.insert(std::move(object->name));
      return true;
    };
    const auto rows = database
                          .Prepare(absl::StrCat("SELECT data FROM ", table,
                                                " WHERE length(data) <= ", kLongestReference))
                          .ReadAll(read);
    if (!rows.ok()) return rows.status();
  }
  return names;
}

// Notes the new ones, forgets ones that something refers to again (a database that was set back),
// and finds the ones that were noted `stay` ago.
absl::StatusOr<std::vector<std::string>> NoteUnreferenced(Connection& writer,
                                                          const std::set<std::string>& names,
                                                          absl::Duration stay) {
  const auto known =
      writer.Prepare("SELECT name FROM unreferenced_objects").ReadAll([](const Statement& row) {
        return row.Text(0);
      });
  if (!known.ok()) return known.status();
  for (const std::string& name : *known) {
    if (names.contains(name)) continue;
    const absl::Status status =
        writer.Prepare("DELETE FROM unreferenced_objects WHERE name = ?").Bind(name).Run();
    if (!status.ok()) return status;
  }
  for (const std::string& name : names) {
    const absl::Status status = writer
                                    .Prepare(
                                        "INSERT INTO unreferenced_objects (name, since) "
                                        "VALUES (?, clock_timestamp()) ON CONFLICT DO NOTHING")
                                    .Bind(name)
                                    .Run();
    if (!status.ok()) return status;
  }
  return writer
      .Prepare(
          "SELECT name FROM unreferenced_objects WHERE "
          "extract(epoch FROM clock_timestamp() - since) >= ?")
      .Bind(absl::ToDoubleSeconds(stay))
      .ReadAll([](const Statement& row) { return row.Text(0); });
}

}  // namespace

absl::StatusOr<std::unique_ptr<LargeValues>> OpenSiteBucket(Connection& database) {
  const absl::StatusOr<std::optional<Place>> place = FindPlace(database);
  if (!place.ok()) return place.status();
  if (!*place) return nullptr;
  return OpenAt(**place);
}

absl::StatusOr<std::unique_ptr<LargeValues>> OpenOwnersBucket(Connection& writer,
                                                              const std::string& url,
                                                              const std::string& schema,
                                                              size_t smallest) {
  absl::StatusOr<std::optional<Place>> place = FindPlace(writer);
  if (!place.ok()) return place.status();
  const bool is_new = !*place;
  if (is_new) {
    if (url.empty()) return nullptr;
    auto made = NewPlace(url, schema);
    if (!made.ok()) return made.status();
    *place = *std::move(made);
  } else if (!url.empty() && url != (*place)->url) {
    return absl::FailedPreconditionError(absl::StrCat(
        "the large values of this map are in the bucket ", (*place)->url, ", not in ", url,
        ": where its objects were moved there, UPDATE ", schema, ".bucket SET url = '", url, "'"));
  }
  auto values = OpenAt(**place, smallest);
  if (!values.ok()) return values;
  absl::Status status = (*values)->Describe(
      absl::StrCat("Large values of a map of Isthmus, to which the tables of the schema ", schema,
                   " of its database refer. Delete none by hand.\n"));
  if (status.ok() && is_new) status = NotePlace(writer, **place);
  if (!status.ok()) return status;
  return values;
}

absl::StatusOr<SweptObjects> SweepObjects(LargeValues& values, const RunOnConnection& read,
                                          const RunOnConnection& write, absl::Duration stay) {
  // In this order: an object written meanwhile is referred to, or is not listed yet.
  const absl::StatusOr<std::vector<std::string>> listed = values.List();
  if (!listed.ok()) return listed.status();
  std::set<std::string> referenced;
  absl::Status status = read([&](Connection& database) -> absl::Status {
    auto names = ReadReferenced(database);
    if (!names.ok()) return names.status();
    referenced = *std::move(names);
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  std::set<std::string> unreferenced(listed->begin(), listed->end());
  for (const std::string& name : referenced) unreferenced.erase(name);
  std::vector<std::string> overdue;
  status = write([&](Connection& database) -> absl::Status {
    auto found = NoteUnreferenced(database, unreferenced, stay);
    if (!found.ok()) return found.status();
    overdue = *std::move(found);
    return absl::OkStatus();
  });
  if (!status.ok()) return status;
  SweptObjects swept{listed->size(), unreferenced.size(), 0};
  for (const std::string& name : overdue) {
    if (status = values.Delete(name); !status.ok()) return status;
    ++swept.deleted;
  }
  return swept;
}

}  // namespace isthmus::storage
