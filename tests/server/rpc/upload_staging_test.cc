// Uploads that are cut off, taken over, too many, or left lying about.
#include "server/rpc/upload_staging.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <random>

namespace isthmus::rpc {
namespace {

UploadKey KeyOf(uint32_t index, uint64_t size, char content = 'a') {
  return {{SessionId("bob-1"), index}, size, 17, std::string(32, content)};
}

class UploadStagingTest : public testing::TestWithParam<bool> {
 protected:
  UploadStagingTest() {
    if (!GetParam()) return;
    folder_ = testing::TempDir() + "isthmus_uploads_" + std::to_string(getpid());
    std::filesystem::remove_all(folder_);
  }
  ~UploadStagingTest() override {
    if (!folder_.empty()) std::filesystem::remove_all(folder_);
  }
  bool on_disk() const { return GetParam(); }
  size_t Files() const {
    const std::filesystem::directory_iterator files(folder_), none;
    return static_cast<size_t>(std::distance(files, none));
  }

  std::string folder_;
};

TEST_P(UploadStagingTest, GoesOnWhereItWasCutOff) {
  std::string content(300'000, '\0');
  std::mt19937 random(3);
  for (char& c : content) c = static_cast<char>(random());
  const UploadKey key = KeyOf(0, content.size());
  auto staging = std::make_unique<UploadStaging>(folder_, 1 << 20);
  uint64_t arrived = 0;
  while (arrived < content.size()) {
    if (on_disk()) staging = std::make_unique<UploadStaging>(folder_, 1 << 20);  // A restart.
    EXPECT_EQ(staging->Persisted(key), arrived);
    auto part = staging->BeginUpload(key);
    ASSERT_TRUE(part.ok()) << part.status();
    ASSERT_EQ((*part)->size(), arrived);
    for (int chunks = 0; chunks < 3 && arrived < content.size(); ++chunks) {
      const size_t size = std::min<size_t>(random() % 20'000, content.size() - arrived);
      ASSERT_TRUE((*part)->Append(arrived, content.substr(arrived, size)).ok());
      arrived += size;
    }
  }
  auto part = staging->BeginUpload(key);
  ASSERT_TRUE(part.ok());
  EXPECT_EQ(*(*part)->TakeData(), content);
  staging->Drop(key.id);
  EXPECT_EQ(staging->Persisted(key), 0u);
  EXPECT_EQ(on_disk() ? Files() : 0u, 0u);
}

TEST_P(UploadStagingTest, WhatIsSentAgainTakesThePlaceOfWhatWasThere) {
  UploadStaging staging(folder_, 1000);
  auto part = staging.BeginUpload(KeyOf(0, 6));
  ASSERT_TRUE((*part)->Append(0, "abcd").ok());
  ASSERT_TRUE((*part)->Append(2, "xy").ok());
  ASSERT_TRUE((*part)->Append(4, "z!").ok());
  EXPECT_EQ(*(*part)->TakeData(), "abxyz!");
}

TEST_P(UploadStagingTest, AnotherContentBeginsAnew) {
  UploadStaging staging(folder_, 1000);
  ASSERT_TRUE((*staging.BeginUpload(KeyOf(0, 6)))->Append(0, "abcd").ok());
  EXPECT_EQ(staging.Persisted(KeyOf(0, 6)), 4u);
  EXPECT_EQ(staging.Persisted(KeyOf(0, 6, 'b')), 0u);
  EXPECT_EQ((*staging.BeginUpload(KeyOf(0, 6, 'b')))->size(), 0u);
  EXPECT_EQ(staging.Persisted(KeyOf(0, 6)), 0u);
}

TEST_P(UploadStagingTest, ANewerCallTakesOver) {
  UploadStaging staging(folder_, 1000);
  int told = 0;
  auto old = staging.BeginUpload(KeyOf(0, 6), [&told] { ++told; });
  ASSERT_TRUE((*old)->Append(0, "ab").ok());
  auto next = staging.BeginUpload(KeyOf(0, 6));
  EXPECT_EQ(told, 1);
  ASSERT_TRUE((*next)->Append(0, "ABC").ok());
  EXPECT_TRUE(absl::IsAborted((*old)->Append(2, "cd")));
  EXPECT_TRUE(absl::IsAborted((*old)->TakeData().status()));
  old->reset();
  ASSERT_TRUE((*next)->Append(3, "DEF").ok());
  EXPECT_EQ(*(*next)->TakeData(), "ABCDEF");
}

TEST_P(UploadStagingTest, OneSessionCannotFillTheDisk) {
  UploadStaging staging(folder_, 100);
  ASSERT_TRUE(staging.BeginUpload(KeyOf(0, 60)).ok());
  EXPECT_TRUE(absl::IsResourceExhausted(staging.BeginUpload(KeyOf(1, 60)).status()));
  EXPECT_TRUE(staging.BeginUpload(KeyOf(1, 40)).ok());
  UploadKey other = KeyOf(0, 60);
  other.id.session = SessionId("carol-1");
  EXPECT_TRUE(staging.BeginUpload(other).ok());
  staging.DropSession(SessionId("bob-1"));
  EXPECT_TRUE(staging.BeginUpload(KeyOf(1, 60)).ok());
}

TEST_P(UploadStagingTest, ManyOfOneByteAreTooMany) {
  UploadStaging staging(folder_, 1000);
  for (uint32_t i = 0; i < 16; ++i) EXPECT_TRUE(staging.BeginUpload(KeyOf(i, 1)).ok()) << i;
  EXPECT_TRUE(absl::IsResourceExhausted(staging.BeginUpload(KeyOf(16, 1)).status()));
  EXPECT_TRUE(staging.BeginUpload(KeyOf(3, 1)).ok());
  staging.Drop(KeyOf(3, 1).id);
  EXPECT_TRUE(staging.BeginUpload(KeyOf(16, 1)).ok());
}

TEST_P(UploadStagingTest, AHashOfAnotherSizeIsRefused) {
  UploadStaging staging(folder_, 1000);
  UploadKey key = KeyOf(0, 6);
  key.sha256 = std::string(31, 'a');
  EXPECT_TRUE(absl::IsInvalidArgument(staging.BeginUpload(key).status()));
  key.sha256 = std::string(1 << 20, 'a');
  EXPECT_TRUE(absl::IsInvalidArgument(staging.BeginUpload(key).status()));
  key.sha256.clear();
  EXPECT_TRUE(staging.BeginUpload(key).ok());
}

TEST_P(UploadStagingTest, WhatNobodyTouchesForAWeekGoesWhileTheServerRuns) {
  ManualClock clock;
  const int64_t day_ns = int64_t{24} * 3600 * 1'000'000'000;
  UploadStaging staging(folder_, 1000, clock);
  ASSERT_TRUE((*staging.BeginUpload(KeyOf(0, 6)))->Append(0, "ab").ok());
  auto touched = *staging.BeginUpload(KeyOf(1, 6));
  clock.Advance(5 * day_ns);
  ASSERT_TRUE(touched->Append(0, "ab").ok());
  clock.Advance(3 * day_ns);
  ASSERT_TRUE(staging.BeginUpload(KeyOf(2, 6)).ok());
  EXPECT_EQ(staging.Persisted(KeyOf(0, 6)), 0u);
  ASSERT_TRUE(touched->Append(2, "cdef").ok());
  EXPECT_EQ(*touched->TakeData(), "abcdef");
}

TEST_P(UploadStagingTest, WhatNobodyTouchedForAWeekIsRemovedAndWhatIsDamagedToo) {
  if (!on_disk()) return;
  {
    UploadStaging staging(folder_, 1000);
    for (uint32_t i = 0; i < 3; ++i)
      ASSERT_TRUE((*staging.BeginUpload(KeyOf(i, 6)))->Append(0, "ab").ok());
  }
  const auto old = std::filesystem::file_time_type::clock::now() - std::chrono::hours(8 * 24);
  std::filesystem::last_write_time(folder_ + "/bob-1-0.part", old);
  std::ofstream(folder_ + "/bob-1-1.part") << "isthmus-upload-1 6 17 zz\nab";
  UploadStaging staging(folder_, 1000);
  EXPECT_EQ(Files(), 1u);
  EXPECT_EQ(staging.Persisted(KeyOf(2, 6)), 2u);
}

INSTANTIATE_TEST_SUITE_P(InMemoryAndOnDisk, UploadStagingTest, testing::Bool(),
                         [](const auto& tested) { return tested.param ? "Disk" : "Memory"; });

}  // namespace
}  // namespace isthmus::rpc
