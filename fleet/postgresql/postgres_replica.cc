#include "fleet/postgresql/postgres_replica.h"

#include <absl/strings/str_cat.h>

#include <utility>
#include <vector>

#include "fleet/postgresql/limits.h"
#include "fleet/postgresql/migrations.h"
#include "fleet/postgresql/postgres_follower.h"
#include "fleet/postgresql/postgres_store.h"
#include "fleet/postgresql/postgresql.h"
#include "fleet/postgresql/site_bucket.h"
#include "fleet/postgresql/unowned_store.h"

namespace isthmus::storage {
namespace {

class ReadOnlyStore : public UnownedStore {
 public:
  ReadOnlyStore(std::vector<std::unique_ptr<Connection>> readers,
                std::unique_ptr<LargeValues> large_values)
      : UnownedStore(nullptr, std::move(readers), std::move(large_values), OpenSiteBucket) {}

  absl::Status PutFeatures(const FeatureBlob&) override { return Refused(); }
};

}  // namespace

absl::StatusOr<PostgresReplica> OpenPostgresReplica(const std::string& url,
                                                    const std::string& site) {
  if (absl::Status status = CheckSite(site); !status.ok()) return status;
  PostgresTarget target;
  target.url = url;
  target.schema = SchemaOfSite(site);
  target.is_read_only = true;
  target.application = absl::StrCat(target.schema, " follower");
  auto following = PostgresConnection::Open(target);
  if (!following.ok()) return following.status();
  if (auto status = CheckMigrated(**following, target.schema); !status.ok()) return status;
  auto large_values = OpenSiteBucket(**following);
  if (!large_values.ok()) return large_values.status();
  target.application = absl::StrCat(target.schema, " replica");
  std::vector<std::unique_ptr<Connection>> readers;
  for (int i = 0; i < kPostgresReaders; ++i) {
    auto reader = PostgresConnection::Open(target);
    if (!reader.ok()) return reader.status();
    readers.push_back(*std::move(reader));
  }
  PostgresReplica replica;
  replica.store = std::make_unique<ReadOnlyStore>(std::move(readers), *std::move(large_values));
  replica.follower = std::make_unique<PostgresFollower>(*std::move(following));
  return replica;
}

}  // namespace isthmus::storage
