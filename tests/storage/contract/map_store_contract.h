// A store of every kind, empty, for tests of what all of them promise.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "storage/memory_store.h"
#include "storage/sqlite/sqlite_store.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::storage {

enum class Kind { kMemory, kSqlite };

class MapStoreContract : public ::testing::TestWithParam<Kind> {
 protected:
  void SetUp() override {
    if (GetParam() == Kind::kMemory) {
      store_ = MakeMemoryStore();
      return;
    }
    SqliteOptions options;
    options.sync_every_commit = false;
    auto store = OpenSqliteStore(folder_.path(), options);
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

inline std::string NameOf(const ::testing::TestParamInfo<Kind>& info) {
  return info.param == Kind::kMemory ? "Memory" : "Sqlite";
}

}  // namespace isthmus::storage
