// The store in PostgreSQL with all large values in a bucket, and all that could be, for the tests
// of what all stores promise.
#include "fleet/postgresql/postgres_store.h"
#include "tests/fleet/objects/s3_server.h"
#include "tests/fleet/postgresql/postgres_server.h"
#include "tests/storage/contract/map_store_contract.h"

namespace isthmus::storage {

const std::vector<StoreKind>& StoresOfContract() {
  static const std::vector<StoreKind> kStores = {
      {"Bucket", [](const std::string&) {
         PostgresServer& server = PostgresServer::Shared();
         return OpenPostgresStore(server.url(), server.NewSite(),
                                  {.bucket = S3Server::Shared().NewUrl(), .smallest_object = 0});
       }}};
  return kStores;
}

}  // namespace isthmus::storage
