#include "server/map/submap_cache.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "storage/forwarding_store.h"
#include "storage/memory_store.h"
#include "storage/sqlite/sqlite_store.h"
#include "tests/storage/faulty_store.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::server {
namespace {

const SessionId kSession("alice-1");
constexpr size_t kPoints = 1000;

Submap LargeSubmap(uint32_t index) {
  Submap submap;
  submap.id = {kSession, index};
  submap.robot = RobotId("alice");
  submap.first_sequence = submap.last_sequence = index + 1;
  submap.keyframes.push_back({index + 1, 1000 * index, Pose()});
  for (size_t i = 0; i < kPoints; ++i) {
    submap.points.push_back({0.01f * static_cast<float>(i), static_cast<float>(index), 1, 0, 0});
  }
  return submap;
}

// One that gives other objects than it was given.
std::unique_ptr<storage::MapStore> OpenIn(const std::string& folder) {
  std::filesystem::create_directories(folder);
  return storage::OpenSqliteStore(folder).value();
}

class SubmapCacheTest : public testing::Test {
 protected:
  SubmapCacheTest()
      : faults_(std::make_shared<storage::Faults>()),
        store_(storage::MakeFaultyStore(OpenIn(folder_.path()), faults_)) {
    storage::WriteBatch batch;
    SessionRecord record;
    record.id = kSession;
    record.robot = RobotId("alice");
    batch.sessions.push_back(record);
    for (uint32_t i = 0; i < 10; ++i) {
      batch.submaps.push_back(std::make_shared<const Submap>(LargeSubmap(i)));
    }
    EXPECT_TRUE(store_->Write(batch).ok());
  }

  // Room for so many submaps.
  std::unique_ptr<SubmapCache> Cache(size_t submaps) {
    return std::make_unique<SubmapCache>(store_.get(), submaps * BytesOf(LargeSubmap(0)) + 100,
                                         [this](const SubmapId& id, const std::string& problem) {
                                           damaged_.emplace_back(id.index, problem);
                                         });
  }

  const storage::TemporaryFolder folder_;
  const std::shared_ptr<storage::Faults> faults_;
  const std::unique_ptr<storage::MapStore> store_;
  std::vector<std::pair<uint32_t, std::string>> damaged_;
};

TEST_F(SubmapCacheTest, KeepsTheLimitWhateverIsAsked) {
  const auto cache = Cache(3);
  const size_t limit = 3 * BytesOf(LargeSubmap(0)) + 100;
  for (const uint32_t index : {0, 1, 2, 3, 2, 9, 8, 7, 6, 0, 5, 5, 4}) {
    const std::shared_ptr<const Submap> submap = cache->Get({kSession, index});
    ASSERT_NE(submap, nullptr);
    EXPECT_EQ(submap->points.size(), kPoints);
    EXPECT_EQ(submap->points[0].y, static_cast<float>(index));
    EXPECT_LE(cache->bytes(), limit);
  }
  cache->Put(std::make_shared<const Submap>(LargeSubmap(10)));
  EXPECT_LE(cache->bytes(), limit);
}

TEST_F(SubmapCacheTest, WhatWasAskedForLastIsNotReadAgain) {
  const auto cache = Cache(2);
  cache->Get({kSession, 0});
  cache->Get({kSession, 1});
  cache->Get({kSession, 0});
  cache->Get({kSession, 2});  // Sends 1 away.
  faults_->FailReads(absl::UnavailableError("no disk"));
  EXPECT_NE(cache->Get({kSession, 0}), nullptr);
  EXPECT_NE(cache->Get({kSession, 2}), nullptr);
  EXPECT_EQ(cache->Get({kSession, 1}), nullptr);
  faults_->FailReads(absl::OkStatus());
  EXPECT_NE(cache->Get({kSession, 1}), nullptr);
  EXPECT_TRUE(damaged_.empty());
}

TEST_F(SubmapCacheTest, WhatSomebodyHoldsIsHandedOutAgain) {
  const auto cache = Cache(0);
  const std::shared_ptr<const Submap> held = cache->Get({kSession, 4});
  EXPECT_EQ(cache->bytes(), 0u);
  EXPECT_EQ(cache->Get({kSession, 4}), held);
}

TEST_F(SubmapCacheTest, OutlinesHaveAllButPointsAndStay) {
  const auto cache = Cache(1);
  const std::shared_ptr<const Submap> outline = cache->Outline({kSession, 3});
  ASSERT_NE(outline, nullptr);
  EXPECT_TRUE(outline->points.empty());
  EXPECT_EQ(outline->keyframes.size(), 1u);
  EXPECT_EQ(outline->last_sequence, 4u);
  for (uint32_t i = 0; i < 10; ++i) cache->Get({kSession, i});
  EXPECT_EQ(cache->Outline({kSession, 3}), outline);
}

TEST_F(SubmapCacheTest, ADamagedSubmapIsToldOnceAndLeftOut) {
  const auto cache = Cache(3);
  faults_->Damage({kSession, 5});
  EXPECT_EQ(cache->Get({kSession, 5}), nullptr);
  EXPECT_EQ(cache->Outline({kSession, 5}), nullptr);
  ASSERT_EQ(damaged_.size(), 1u);
  EXPECT_EQ(damaged_[0].first, 5u);
  EXPECT_FALSE(damaged_[0].second.empty());
  EXPECT_NE(cache->Get({kSession, 6}), nullptr);
}

TEST_F(SubmapCacheTest, WhatIsGoneIsGone) {
  const auto cache = Cache(3);
  cache->Get({kSession, 1});
  cache->Outline({kSession, 1});
  storage::WriteBatch batch;
  batch.retired.push_back({kSession, 1});
  ASSERT_TRUE(store_->Write(batch).ok());
  cache->Forget({kSession, 1});
  EXPECT_EQ(cache->Get({kSession, 1}), nullptr);
  EXPECT_EQ(cache->Outline({kSession, 1}), nullptr);
  EXPECT_EQ(cache->bytes(), 0u);
  EXPECT_TRUE(damaged_.empty());
}

// Memory may be there again; any other exception would be thrown again.
TEST_F(SubmapCacheTest, WhatCannotBeReadForWantOfMemoryIsToldOnceAndAskedForAgain) {
  class Throwing : public storage::ForwardingStore {
   public:
    using ForwardingStore::ForwardingStore;
    absl::StatusOr<std::shared_ptr<const Submap>> GetSubmap(const SubmapId& id) const override {
      if (id.index == 1 && throws) throw std::bad_alloc();
      if (id.index == 2 && throws) throw std::runtime_error("no such thing");
      return std::make_shared<const Submap>(LargeSubmap(id.index));
    }
    bool throws = true;
  } store(storage::MakeMemoryStore());
  SubmapCache cache(&store, 1 << 20, [this](const SubmapId& id, const std::string& problem) {
    damaged_.emplace_back(id.index, problem);
  });
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(cache.Get({kSession, 1}), nullptr);
    EXPECT_EQ(cache.Outline({kSession, 2}), nullptr);
  }
  ASSERT_EQ(damaged_.size(), 2u);
  EXPECT_NE(damaged_[0].second.find("alice-1/1 cannot be read"), std::string::npos);
  EXPECT_NE(damaged_[1].second.find("no such thing"), std::string::npos);
  store.throws = false;
  EXPECT_NE(cache.Get({kSession, 1}), nullptr);
  EXPECT_EQ(cache.Get({kSession, 2}), nullptr);
}

}  // namespace
}  // namespace isthmus::server
