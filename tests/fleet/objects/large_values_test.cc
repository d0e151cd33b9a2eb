// Large values of a map in PostgreSQL, in a bucket.
#include "storage/objects/large_values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "fleet/copy/copy_map.h"
#include "fleet/postgresql/postgres_replica.h"
#include "fleet/postgresql/postgres_store.h"
#include "fleet/postgresql/postgresql.h"
#include "fleet/postgresql/site_bucket.h"
#include "fleet/postgresql/worker_store.h"
#include "storage/sqlite/sqlite_store.h"
#include "tests/fleet/objects/s3_server.h"
#include "tests/fleet/postgresql/postgres_server.h"
#include "tests/storage/records.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;
using ::testing::HasSubstr;

class LargeValuesTest : public ::testing::Test {
 protected:
  std::unique_ptr<MapStore> Open(const std::string& bucket) {
    auto store = OpenPostgresStore(server_.url(), site_, {.bucket = bucket});
    EXPECT_TRUE(store.ok()) << store.status();
    return store.ok() ? *std::move(store) : nullptr;
  }
  static std::string StateOf(const std::string& session) { return std::string(70'000, session[0]); }
  // A session with a submap, a checkpoint and features, all of them large.
  static WriteBatch MakeBatch(const std::string& session = "alice-1") {
    return {.sessions = {MakeSession(session)},
            .checkpoints = {{SessionId(session), 3, 3, StateOf(session)}},
            .submaps = {MakeSubmap(session, 0, session == "alice-1" ? kPoints : kPoints + 1)}};
  }
  void Fill(MapStore& store) {
    const absl::Status status = store.Write(MakeBatch());
    ASSERT_TRUE(status.ok()) << status;
    ASSERT_TRUE(store.PutFeatures({alice_, "prepared-v1", features_}).ok());
  }
  void ExpectFilled(const MapStore& store) {
    const auto submap = store.GetSubmap(alice_);
    ASSERT_TRUE(submap.ok()) << submap.status();
    EXPECT_EQ((*submap)->points.size(), kPoints);
    EXPECT_EQ(*store.GetFeatures(alice_, "prepared-v1"), features_);
    EXPECT_EQ(*store.GetCheckpoint(alice_.session)->data, StateOf("alice-1"));
  }
  std::vector<std::string> Objects() {  // Without the one for people.
    std::vector<std::string> files = s3_->Objects();
    std::erase_if(files, [](const std::string& f) { return f.find("about.txt") != f.npos; });
    return files;
  }
  SweptObjects Sweep(absl::Duration stay) {
    auto database = PostgresConnection::Open({server_.url(), SchemaOfSite(site_), "test", true});
    EXPECT_TRUE(database.ok()) << database.status();
    const auto run = [&](const auto& work) { return work(**database); };
    const auto values = OpenSiteBucket(**database);
    EXPECT_TRUE(values.ok()) << values.status();
    const auto swept = SweepObjects(**values, run, run, stay);
    EXPECT_TRUE(swept.ok()) << swept.status();
    return *swept;
  }

  static constexpr size_t kPoints = 20'000;
  PostgresServer& server_ = PostgresServer::Shared();
  const std::string site_ = server_.NewSite();
  const std::unique_ptr<S3Server> s3_ = S3Server::Start();
  const std::string url_ = s3_->NewUrl();
  const SubmapId alice_{SessionId("alice-1"), 0};
  const std::string features_ = std::string(50'000, 'f');
};

TEST_F(LargeValuesTest, AreInTheBucketAndStayThere) {
  Fill(*Open(url_));
  EXPECT_EQ(Objects().size(), 3u);
  const auto store = Open("");  // The site knows where.
  ExpectFilled(*store);
  EXPECT_GT(*store->StoredBytes(alice_.session), 80'000u);
  ASSERT_TRUE(store->PutFeatures({alice_, "small", "abc"}).ok());
  EXPECT_EQ(Objects().size(), 3u);
  auto database = PostgresConnection::Open({server_.url(), SchemaOfSite(site_), "test", true});
  for (const char* table : {"submap_blobs", "checkpoints", "features"}) {
    EXPECT_LE(*(*database)->ReadNumber(absl::StrCat("SELECT max(length(data)) FROM ", table)),
              int64_t{kLongestReference})
        << table;
  }
}

TEST_F(LargeValuesTest, WhatLooksLikeAReferenceIsAValue) {
  const auto store = Open(url_);
  Fill(*store);
  const std::string sly = "isthmus object 1 00112233445566778899aabbccddeeff 3 12";
  ASSERT_TRUE(FindReference(sly).has_value());
  ASSERT_TRUE(store->PutFeatures({alice_, "sly", sly}).ok());
  EXPECT_EQ(*store->GetFeatures(alice_, "sly"), sly);
}

TEST_F(LargeValuesTest, OfASiteThatHadNoneGoThereFromThenOn) {
  Fill(*Open(""));
  EXPECT_EQ(s3_->Objects().size(), 0u);
  const auto store = Open(url_);
  ExpectFilled(*store);
  ASSERT_TRUE(store->Write(MakeBatch("bob-1")).ok());
  EXPECT_EQ(Objects().size(), 2u);
}

TEST_F(LargeValuesTest, WhileTheBucketIsAwayNothingIsTakenAndNothingIsDamaged) {
  const auto store = Open(url_);
  Fill(*store);
  s3_->Kill();
  EXPECT_EQ(store->Write(MakeBatch("bob-1")).code(), StatusCode::kUnavailable);
  EXPECT_EQ(store->PutFeatures({alice_, "other", features_ + "x"}).code(),
            StatusCode::kUnavailable);
  EXPECT_EQ(store->GetSubmap(alice_).status().code(), StatusCode::kUnavailable);
  EXPECT_EQ(store->GetFeatures(alice_, "prepared-v1").status().code(), StatusCode::kUnavailable);
  EXPECT_EQ(store->GetCheckpoint(alice_.session).status().code(), StatusCode::kUnavailable);
  EXPECT_EQ(store->ListSessions()->size(), 1u);
  ASSERT_TRUE(s3_->StartAgain());
  ExpectFilled(*store);
  EXPECT_TRUE(store->Write(MakeBatch("bob-1")).ok());
}

TEST_F(LargeValuesTest, WhatIsStoredAgainAndAgainIsOneObject) {
  const auto store = Open(url_);
  Fill(*store);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(store->Write(MakeBatch()).code(), StatusCode::kAlreadyExists);
    EXPECT_TRUE(store->PutFeatures({alice_, "prepared-v1", features_}).ok());
  }
  EXPECT_EQ(Objects().size(), 3u);
  ExpectFilled(*store);
}

// A whole bucket that is not there says nothing of an object, nor does a proxy's 404.
TEST_F(LargeValuesTest, WithoutTheBucketNothingIsTakenForGone) {
  const auto store = Open(url_);
  Fill(*store);
  const std::string folder = s3_->bucket_folder();
  std::filesystem::rename(folder, folder + ".aside");
  EXPECT_EQ(store->GetSubmap(alice_).status().code(), StatusCode::kUnavailable);
  EXPECT_EQ(store->GetCheckpoint(alice_.session).status().code(), StatusCode::kUnavailable);
  EXPECT_EQ(OpenWorkerStore(server_.url(), site_).status().code(), StatusCode::kFailedPrecondition);
  std::filesystem::rename(folder + ".aside", folder);
  ExpectFilled(*store);
}

TEST_F(LargeValuesTest, WhatIsDamagedOrGoneIsSaid) {
  const auto store = Open(url_);
  Fill(*store);
  for (const std::string& file : Objects()) std::ofstream(file) << "something else";
  const absl::Status damaged = store->GetSubmap(alice_).status();
  EXPECT_EQ(damaged.code(), StatusCode::kDataLoss);
  EXPECT_THAT(damaged.message(), HasSubstr("alice-1"));
  EXPECT_EQ(store->GetFeatures(alice_, "prepared-v1").status().code(), StatusCode::kDataLoss);
  const auto checkpoint = store->GetCheckpoint(alice_.session);
  ASSERT_TRUE(checkpoint.ok()) << checkpoint.status();
  EXPECT_EQ(checkpoint->sequence, 3u);
  EXPECT_FALSE(checkpoint->data.has_value());
  auto database = PostgresConnection::Open({server_.url(), SchemaOfSite(site_), "test", true});
  const auto values = OpenSiteBucket(**database);
  const auto names = (*values)->List();
  ASSERT_EQ(names->size(), 3u);
  for (const std::string& name : *names) ASSERT_TRUE((*values)->Delete(name).ok());
  EXPECT_EQ(store->GetSubmap(alice_).status().code(), StatusCode::kDataLoss);
}

TEST_F(LargeValuesTest, ReplicasAndWorkersReadThem) {
  const auto store = Open(url_);
  Fill(*store);
  const auto replica = OpenPostgresReplica(server_.url(), site_);
  ASSERT_TRUE(replica.ok()) << replica.status();
  ExpectFilled(*replica->store);
  const auto worker = OpenWorkerStore(server_.url(), site_);
  ASSERT_TRUE(worker.ok()) << worker.status();
  EXPECT_TRUE((*worker)->GetSubmap(alice_).ok());
  ASSERT_TRUE((*worker)->PutFeatures({alice_, "by a worker", features_}).ok());
  EXPECT_EQ(*store->GetFeatures(alice_, "by a worker"), features_);
  EXPECT_EQ(Objects().size(), 4u);
}

TEST_F(LargeValuesTest, WhoReadsFindsThemThoughTheSiteHadNoneBefore) {
  ASSERT_NE(Open(""), nullptr);
  const auto replica = OpenPostgresReplica(server_.url(), site_);
  const auto worker = OpenWorkerStore(server_.url(), site_);
  ASSERT_TRUE(replica.ok() && worker.ok()) << replica.status() << worker.status();
  Fill(*Open(url_));
  ExpectFilled(*replica->store);
  EXPECT_TRUE((*worker)->GetSubmap(alice_).ok());
}

TEST_F(LargeValuesTest, ASiteHasOneBucket) {
  Fill(*Open(url_));
  const absl::Status other =
      OpenPostgresStore(server_.url(), site_, {.bucket = s3_->NewUrl()}).status();
  EXPECT_EQ(other.code(), StatusCode::kFailedPrecondition);
  EXPECT_THAT(other.message(), HasSubstr(url_));
  ExpectFilled(*Open(url_));
}

TEST_F(LargeValuesTest, AreSweptOnceNothingHasReferredToThemForLong) {
  const auto store = Open(url_);
  Fill(*store);
  for (uint64_t sequence : {4, 5}) {
    const std::string state(70'000, static_cast<char>(sequence));
    ASSERT_TRUE(store->Write({.checkpoints = {{alice_.session, sequence, 3, state}}}).ok());
  }
  SweptObjects swept = Sweep(absl::Hours(1));
  EXPECT_EQ(swept.objects, 5u);
  EXPECT_EQ(swept.unreferenced, 2u);
  EXPECT_EQ(swept.deleted, 0u);
  swept = Sweep(absl::ZeroDuration());
  EXPECT_EQ(swept.deleted, 2u);
  EXPECT_EQ(Objects().size(), 3u);
  EXPECT_TRUE(store->GetSubmap(alice_).ok());
  EXPECT_TRUE(store->GetCheckpoint(alice_.session)->data.has_value());
  ASSERT_TRUE(store->DeleteSession(alice_.session).ok());
  EXPECT_EQ(Sweep(absl::ZeroDuration()).deleted, 3u);
  EXPECT_EQ(Objects().size(), 0u);
}

// As one that a sweep saw before its transaction was committed, or of a database set back.
TEST_F(LargeValuesTest, AreNotSweptOnceSomethingRefersToThemAgain) {
  const auto store = Open(url_);
  Fill(*store);
  const std::string table = "\"" + SchemaOfSite(site_) + "\".features";
  ASSERT_TRUE(server_.Execute("CREATE TABLE aside_" + site_ + " AS SELECT data FROM " + table));
  ASSERT_TRUE(server_.Execute("UPDATE " + table + " SET data = ''"));
  EXPECT_EQ(Sweep(absl::Hours(1)).unreferenced, 1u);
  ASSERT_TRUE(server_.Execute("UPDATE " + table + " SET data = a.data FROM aside_" + site_ + " a"));
  EXPECT_EQ(Sweep(absl::ZeroDuration()).unreferenced, 0u);
  ExpectFilled(*store);
}

TEST_F(LargeValuesTest, GoAlongWithACopy) {
  TemporaryFolder first, second;
  const MapPlace there = {server_.url(), site_, url_};
  {
    auto store = OpenSqliteStore(first.path(), {.sync_every_commit = false});
    ASSERT_TRUE(store.ok()) << store.status();
    Fill(**store);
  }
  const auto copied = CopyMap({first.path()}, there);
  ASSERT_TRUE(copied.ok()) << copied.status();
  EXPECT_EQ(Objects().size(), 3u);
  ExpectFilled(*Open(""));
  const auto back = CopyMap(there, {second.path()});
  ASSERT_TRUE(back.ok()) << back.status();
  ExpectFilled(**OpenSqliteStore(second.path()));
  for (const std::string& file : Objects()) std::ofstream(file) << "something else";
  TemporaryFolder third;
  EXPECT_EQ(CopyMap(there, {third.path()}).status().code(), StatusCode::kDataLoss);
  EXPECT_EQ(CopyMap({first.path()}, {third.path(), "", url_}).status().code(),
            StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace isthmus::storage
