// A map in a database that another server writes: the only change here is PutFeatures, which keeps
// data that follow from the submaps anyway.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "core/codec/quantized.h"
#include "storage/sql/sql_store.h"

namespace isthmus::storage {

class UnownedStore : public SqlStore {
 public:
  // The writer may be null where PutFeatures is overridden as well. Stores no submaps, so it rounds
  // none.
  UnownedStore(std::unique_ptr<Connection> writer, std::vector<std::unique_ptr<Connection>> readers,
               std::unique_ptr<LargeValues> large_values, FindLargeValues find)
      : SqlStore(std::move(writer), std::move(readers), codec::kMinResolutionM,
                 std::move(large_values), find) {}

  bool IsRemote() const override { return true; }
  absl::Status Write(const WriteBatch&) override { return Refused(); }
  using MapStore::DeleteSession;
  absl::Status DeleteSession(const SessionId&, const std::vector<Event>&) override {
    return Refused();
  }

 protected:
  static absl::Status Refused() {
    return absl::FailedPreconditionError(
        "the map is open for reading only: another server writes it");
  }
};

}  // namespace isthmus::storage
