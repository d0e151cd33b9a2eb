// Recordings that were cut off or damaged.
#include <absl/strings/match.h>

#include <algorithm>
#include <cstring>

#include "tests/client/readers/messages/damage_helpers.h"

namespace isthmus::readers {
namespace {

using testing::AnyOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr size_t kDriveMessages = 20;

class DamageTest : public testing::TestWithParam<const char*> {
 protected:
  bool IsBag() const { return absl::EndsWith(GetParam(), ".bag"); }
  // The beginnings of chunks, up to the index or summary.
  static std::vector<size_t> Chunks(const std::string& bytes, bool is_bag) {
    std::vector<size_t> chunks;
    if (!is_bag) {
      for (size_t at = 8; at + 9 < bytes.size() && bytes[at] != 0x0F;) {
        uint64_t length = 0;
        std::memcpy(&length, &bytes[at + 1], 8);
        if (bytes[at] == 0x06) chunks.push_back(at);
        at += 9 + length;
      }
      return chunks;
    }
    const std::string compression = "compression=";
    for (size_t at = bytes.find(compression); at != std::string::npos;
         at = bytes.find(compression, at + 1)) {
      chunks.push_back(at - 16);  // Behind its length and its "op".
    }
    return chunks;
  }

  const std::string bytes_ = LoadData(GetParam());
  const AllMessages whole_ = ReadBytes(bytes_);
};

TEST_P(DamageTest, WholeItIsReadWithoutComplaints) {
  EXPECT_EQ(whole_.messages.size(), kDriveMessages);
  EXPECT_THAT(whole_.errors, IsEmpty());
  EXPECT_THAT(whole_.notes, IsEmpty());
}

TEST_P(DamageTest, CutOffAnywhereItIsReadAsFarAsItGoes) {
  size_t most = 0;
  for (size_t size = 13; size < bytes_.size(); size += 7) {
    const AllMessages cut = ReadBytes(bytes_.substr(0, size));
    ASSERT_TRUE(cut.opened) << size;
    const size_t kept = CountKept(whole_.messages, cut.messages);
    EXPECT_GE(kept, most) << size;
    EXPECT_LE(cut.errors.size(), 1u) << size;
    EXPECT_FALSE(cut.notes.empty()) << size;
    for (const std::string& error : cut.errors) {
      EXPECT_THAT(error, Not(HasSubstr("messages lost: 0 "))) << size;
    }
    most = kept;
  }
  EXPECT_EQ(most, kDriveMessages);
}

TEST_P(DamageTest, CutOffItSaysThatNothingTellsWhatIsMissing) {
  const std::vector<size_t> chunks = Chunks(bytes_, IsBag());
  ASSERT_GE(chunks.size(), 3u);
  // Between two chunks, and within one.
  for (const size_t size : {chunks[2], chunks[2] + 60, (chunks[1] + chunks[2]) / 2}) {
    const AllMessages cut = ReadBytes(bytes_.substr(0, size));
    EXPECT_LT(cut.messages.size(), kDriveMessages);
    ASSERT_FALSE(cut.notes.empty());
    EXPECT_THAT(cut.notes[0], HasSubstr("nothing tells how many messages are missing"));
    for (const std::string& error : cut.errors) {
      EXPECT_THAT(error, AnyOf(HasSubstr("how many messages are lost is not known"),
                               HasSubstr("how many are lost is not known")));
    }
  }
}

TEST_P(DamageTest, ADamagedChunkCostsItsMessagesAlone) {
  const std::vector<size_t> chunks = Chunks(bytes_, IsBag());
  ASSERT_GE(chunks.size(), 3u);
  std::string damaged = bytes_;
  // Bags without compression have no checksum: only what makes no record is noticed.
  const size_t first_record = bytes_.find("size=", chunks[1]) + 5 + 4 + 4;
  const size_t at = IsBag() ? first_record : chunks[1] + 150;
  for (size_t i = 0; i < 40; ++i) damaged[at + i] ^= 0x5A;
  const AllMessages left = ReadBytes(damaged);
  const size_t kept = CountKept(whole_.messages, left.messages);
  EXPECT_EQ(left.messages.front(), whole_.messages.front());
  // Without an index nor a summary the names of topics that it declared are lost too.
  if (GetParam() != std::string("drive_bare.mcap")) {
    EXPECT_EQ(left.messages.back(), whole_.messages.back());
  }
  EXPECT_LT(kept, kDriveMessages);
  EXPECT_GE(kept, kDriveMessages / 3);
  ASSERT_EQ(left.errors.size(), 1u);
  EXPECT_THAT(left.errors[0], HasSubstr("bytes " + std::to_string(chunks[1]) + " to "));
}

TEST_P(DamageTest, WithoutAnIndexTheNextChunkIsFound) {
  const std::vector<size_t> chunks = Chunks(bytes_, IsBag());
  ASSERT_GE(chunks.size(), 3u);
  // The head of the second chunk is gone, and so is the end of the file.
  std::string damaged = bytes_.substr(0, chunks.back() + 60);
  std::memset(&damaged[chunks[1]], 0xFF, 30);
  const AllMessages left = ReadBytes(damaged);
  CountKept(whole_.messages, left.messages);
  const AllMessages first = ReadBytes(bytes_.substr(0, chunks[1]));
  EXPECT_GT(left.messages.size(), first.messages.size());
  EXPECT_GE(left.notes.size(), 2u);
  ASSERT_FALSE(left.errors.empty());
  EXPECT_THAT(left.errors[0],
              HasSubstr("bytes " + std::to_string(chunks[1]) + " to " + std::to_string(chunks[2])));
}

TEST_P(DamageTest, SwappedChunksComeInTheOrderOfRecording) {
  const std::vector<size_t> chunks = Chunks(bytes_, IsBag());
  ASSERT_GE(chunks.size(), 3u);
  const auto piece = [&](size_t begin, size_t end) { return bytes_.substr(begin, end - begin); };
  const std::string head = piece(0, chunks[0]);
  const std::string first = piece(chunks[0], chunks[1]), second = piece(chunks[1], chunks[2]);
  const AllMessages in_order = ReadBytes(head + first + second);
  const AllMessages swapped = ReadBytes(head + second + first);
  EXPECT_GE(in_order.messages.size(), 4u);
  EXPECT_EQ(swapped.messages, in_order.messages);
  EXPECT_THAT(swapped.errors, IsEmpty());
}

TEST_P(DamageTest, AnyByteMayBeWrong) {
  for (size_t at = 13; at < bytes_.size(); at += 5) {
    std::string damaged = bytes_;
    damaged[at] ^= 0x41;
    ReadBytes(damaged);  // Ends, and does not crash.
  }
}

INSTANTIATE_TEST_SUITE_P(Chunked, DamageTest,
                         testing::Values("drive_none.bag", "drive_bz2.bag", "drive_lz4.bag",
                                         "drive_none.mcap", "drive_lz4.mcap", "drive_zstd.mcap",
                                         "drive_bare.mcap"),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::replace(name.begin(), name.end(), '.', '_');
                           return name;
                         });

}  // namespace
}  // namespace isthmus::readers
