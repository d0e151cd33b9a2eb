#include "storage/sqlite/tables.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <set>
#include <utility>

#include "storage/sqlite/migrations.h"

namespace isthmus::storage {
namespace {

TableColumn::Kind KindOf(const std::string& type) {
  using Kind = TableColumn::Kind;
  if (type == "TEXT") return Kind::kText;
  if (type == "BLOB") return Kind::kBlob;
  return type == "REAL" ? Kind::kReal : Kind::kNumber;
}

absl::StatusOr<Table> ReadTable(Connection& database, const std::string& name) {
  Table table{name, {}, 0};
  const auto columns = database.Prepare("SELECT name, type, pk FROM pragma_table_info(?)")
                           .Bind(name)
                           .ReadAll([&table](const Statement& row) {
                             table.keys += row.Int(2) > 0 ? 1 : 0;
                             return TableColumn{row.Text(0), KindOf(row.Text(1))};
                           });
  if (!columns.ok()) return columns.status();
  table.columns = *columns;
  for (const TableColumn& column : table.columns) {
    table.has_blobs = table.has_blobs || column.name == "data" || column.name == "edges";
  }
  table.counts_keys = table.columns[0].name == "key";
  return table;
}

absl::StatusOr<std::vector<std::string>> ReadNames(Connection& database, const std::string& sql) {
  return database.Prepare(sql).ReadAll([](const Statement& row) { return row.Text(0); });
}

}  // namespace

absl::StatusOr<std::vector<Table>> MapTables() {
  auto database = SqliteConnection::Open(":memory:");
  if (!database.ok()) return database.status();
  if (absl::Status status = Migrate(**database); !status.ok()) return status;
  auto names = ReadNames(**database,
                         "SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE "
                         "'sqlite_%' ORDER BY rowid");
  if (!names.ok()) return names.status();
  std::vector<Table> tables;
  std::set<std::string> told;
  while (!names->empty()) {
    for (const std::string& name : std::exchange(*names, {})) {
      auto referred = ReadNames(
          **database, absl::StrCat("SELECT \"table\" FROM pragma_foreign_key_list('", name, "')"));
      if (!referred.ok()) return referred.status();
      const bool is_next = std::all_of(
          referred->begin(), referred->end(),
          [&](const std::string& other) { return other == name || told.contains(other); });
      if (!is_next) {
        names->push_back(name);
        continue;
      }
      auto table = ReadTable(**database, name);
      if (!table.ok()) return table.status();
      tables.push_back(*std::move(table));
      told.insert(name);
    }
  }
  return tables;
}

}  // namespace isthmus::storage
