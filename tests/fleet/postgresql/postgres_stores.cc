// The store in PostgreSQL, for the tests of what all stores promise.
#include "fleet/postgresql/postgres_store.h"
#include "tests/fleet/postgresql/postgres_server.h"
#include "tests/storage/contract/map_store_contract.h"

namespace isthmus::storage {

const std::vector<StoreKind>& StoresOfContract() {
  static const std::vector<StoreKind> kStores = {
      {"Postgres", [](const std::string&) {
         PostgresServer& server = PostgresServer::Shared();
         return OpenPostgresStore(server.url(), server.NewSite());
       }}};
  return kStores;
}

}  // namespace isthmus::storage
