// A store of every kind that a test program knows, empty, for tests of what all of them promise.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "storage/map_store.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::storage {

struct StoreKind {
  std::string name;
  // Makes an empty store, in a folder that is for it alone and not made yet.
  std::function<absl::StatusOr<std::unique_ptr<MapStore>>(const std::string& folder)> open;
};

// The stores that the test program names: each program links the tests with its own.
const std::vector<StoreKind>& StoresOfContract();

class MapStoreContract : public ::testing::TestWithParam<StoreKind> {
 protected:
  void SetUp() override {
    auto store = GetParam().open(folder_.path());
    ASSERT_TRUE(store.ok()) << store.status();
    store_ = *std::move(store);
  }

  void Put(const WriteBatch& batch) {
    const absl::Status status = store_->Write(batch);
    ASSERT_TRUE(status.ok()) << status;
  }
  absl::StatusCode CodeOf(const WriteBatch& batch) { return store_->Write(batch).code(); }

  const SessionId alice_{"alice-1"}, bob_{"bob-1"}, nobody_{"nobody-1"};
  TemporaryFolder folder_;
  std::unique_ptr<MapStore> store_;
};

inline std::string NameOf(const ::testing::TestParamInfo<StoreKind>& info) {
  return info.param.name;
}

}  // namespace isthmus::storage
