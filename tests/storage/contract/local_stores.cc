// The stores that need nothing but this machine.
#include "storage/memory_store.h"
#include "storage/sqlite/sqlite_store.h"
#include "tests/storage/contract/map_store_contract.h"

namespace isthmus::storage {

const std::vector<StoreKind>& StoresOfContract() {
  static const std::vector<StoreKind> kStores = {
      {"Memory", [](const std::string&) { return MakeMemoryStore(); }},
      {"Sqlite", [](const std::string& folder) {
         return OpenSqliteStore(folder, {.sync_every_commit = false});
       }}};
  return kStores;
}

}  // namespace isthmus::storage
