// The tables of a map, alike in every database, for code that takes rows as they are.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

namespace isthmus::storage {

struct TableColumn {
  enum class Kind { kNumber, kReal, kText, kBlob };
  std::string name;
  Kind kind = Kind::kNumber;
};

struct Table {
  std::string name;
  std::vector<TableColumn> columns;
  size_t keys = 1;           // So many of the first columns are its key, in whose order rows lie.
  bool has_blobs = false;    // Values of up to some megabytes.
  bool counts_keys = false;  // The database gives new rows their key.
};

// As the migrations make them, each behind the ones that it refers to.
absl::StatusOr<std::vector<Table>> MapTables();

}  // namespace isthmus::storage
