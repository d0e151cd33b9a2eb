// Uploads that are cut off, taken over, too many, or left lying about.
#include "server/rpc/upload_staging.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <random>

namespace isthmus::rpc {
namespace {

UploadKey KeyOf(uint32_t index, uint64_t size, const std::string& sha256 = "abc") {
  return {{SessionId("bob-1"), index}, size, 17, sha256};
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
  EXPECT_EQ((*part)->TakeData(), content);
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
  EXPECT_EQ((*part)->TakeData(), "abxyz!");
}

TEST_P(UploadStagingTest, AnotherContentBeginsAnew) {
  UploadStaging staging(folder_, 1000);
  ASSERT_TRUE((*staging.BeginUpload(KeyOf(0, 6)))->Append(0, "abcd").ok());
  EXPECT_EQ(staging.Persisted(KeyOf(0, 6)), 4u);
  EXPECT_EQ(staging.Persisted(KeyOf(0, 6, "other")), 0u);
  EXPECT_EQ((*staging.BeginUpload(KeyOf(0, 6, "other")))->size(), 0u);
  EXPECT_EQ(staging.Persisted(KeyOf(0, 6)), 0u);
}

TEST_P(UploadStagingTest, ANewerCallTakesOver) {
  UploadStaging staging(folder_, 1000);
  auto old = staging.BeginUpload(KeyOf(0, 6));
  ASSERT_TRUE((*old)->Append(0, "ab").ok());
  auto next = staging.BeginUpload(KeyOf(0, 6));
  ASSERT_TRUE((*next)->Append(0, "ABC").ok());
  EXPECT_TRUE(absl::IsAborted((*old)->Append(2, "cd")));
  old->reset();
  ASSERT_TRUE((*next)->Append(3, "DEF").ok());
  EXPECT_EQ((*next)->TakeData(), "ABCDEF");
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
