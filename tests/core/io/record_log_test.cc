// Logs of records after a crash, on a full or a bad disk.
#include "core/io/record_log.h"

#include <gtest/gtest.h>

#include "tests/core/io/failing_disk.h"

namespace isthmus::io {
namespace {

constexpr char kMarker[] = "test";
constexpr char kHead[] = "a head";

std::string BodyOf(uint64_t sequence) {
  return "record " + std::to_string(sequence) + std::string(10 * sequence, '.');
}

class RecordLogTest : public testing::Test {
 protected:
  RecordLogTest() {
    std::remove(path_.c_str());
    const auto file = AppendFile::Open(path_).value();
    EXPECT_TRUE(file->Append(kHead).ok());
    ends_.push_back(file->size());
    for (uint64_t i = 1; i <= 4; ++i) {
      const auto record = AppendRecord(*file, kMarker, i, -static_cast<int64_t>(i), BodyOf(i));
      EXPECT_TRUE(record.ok()) << record.status();
      EXPECT_EQ(record->end(), file->size());
      ends_.push_back(file->size());
    }
    bytes_ = ReadFile(path_).value();
  }
  ~RecordLogTest() override { std::remove(path_.c_str()); }

  std::unique_ptr<AppendFile> With(const std::string& bytes) {
    EXPECT_TRUE(WriteFile(path_, bytes).ok());
    return AppendFile::Open(path_, disk_.calls()).value();
  }
  absl::StatusOr<RecordIndex> Find(const AppendFile& file, Look look = Look::kBodies) {
    return FindRecords(file, kMarker, ends_[0], look);
  }
  // The sequences of the records found, which are as they were written.
  std::vector<uint64_t> Read(const AppendFile& file) {
    std::vector<uint64_t> sequences;
    const auto index = Find(file);
    EXPECT_TRUE(index.ok()) << index.status();
    for (const Record& record : index->records) {
      EXPECT_EQ(ReadBody(file, record).value(), BodyOf(record.sequence));
      EXPECT_EQ(record.stamp_ns, -static_cast<int64_t>(record.sequence));
      sequences.push_back(record.sequence);
    }
    return sequences;
  }

  using Sequences = std::vector<uint64_t>;
  const std::string path_ = testing::TempDir() + "record_log_" + std::to_string(getpid());
  FailingDisk disk_;
  std::vector<uint64_t> ends_;  // The end of the head, then of each record.
  std::string bytes_;
};

TEST_F(RecordLogTest, TornAnywhereItHoldsTheRecordsBeforeThat) {
  for (size_t size = ends_[0]; size <= bytes_.size(); ++size) {
    const auto file = With(bytes_.substr(0, size));
    size_t whole = 0;
    while (whole < 4 && ends_[whole + 1] <= size) ++whole;
    const auto index = Find(*file);
    ASSERT_TRUE(index.ok()) << index.status();
    ASSERT_EQ(index->records.size(), whole) << size;
    ASSERT_EQ(index->end, ends_[whole]) << size;
    ASSERT_TRUE(index->damaged.empty()) << size;
    // Cut there, it goes on.
    ASSERT_TRUE(file->Truncate(index->end).ok());
    ASSERT_TRUE(AppendRecord(*file, kMarker, 9, -9, BodyOf(9)).ok());
    Sequences expected{1, 2, 3, 4};
    expected.resize(whole);
    expected.push_back(9);
    ASSERT_EQ(Read(*file), expected) << size;
  }
}

TEST_F(RecordLogTest, AFlippedByteCostsItsOwnRecordAlone) {
  for (size_t at = ends_[1]; at < ends_[2]; ++at) {
    std::string flipped = bytes_;
    flipped[at] = static_cast<char>(flipped[at] ^ 0x40);
    const auto file = With(flipped);
    ASSERT_EQ(Read(*file), (Sequences{1, 3, 4})) << at;
    const auto index = Find(*file);
    ASSERT_EQ(index->damaged.size(), 1u) << at;
    EXPECT_EQ(index->damaged[0].offset, ends_[1]);
    EXPECT_EQ(index->damaged[0].size, ends_[2] - ends_[1]);
    const bool in_body = at >= ends_[1] + kRecordHeaderBytes;
    const auto headers = Find(*file, Look::kHeaders);
    ASSERT_EQ(headers->records.size(), in_body ? 4u : 3u) << at;
    if (!in_body) continue;
    EXPECT_TRUE(absl::IsDataLoss(ReadBody(*file, headers->records[1]).status())) << at;
  }
}

TEST_F(RecordLogTest, DamageLongerThanAPieceOfTheSearchIsPassedOver) {
  for (const size_t size : {65'000, 65'505, 65'536, 65'537, 200'000}) {
    std::string damaged = bytes_;
    damaged.insert(ends_[2], std::string(size, 't'));
    EXPECT_EQ(Read(*With(damaged)), (Sequences{1, 2, 3, 4})) << size;
  }
}

TEST_F(RecordLogTest, AFullDiskLeavesNothingHalfWritten) {
  const auto file = With(bytes_);
  for (size_t room = 0; room < kRecordHeaderBytes + BodyOf(5).size(); ++room) {
    disk_.room = room;
    const auto record = AppendRecord(*file, kMarker, 5, -5, BodyOf(5));
    ASSERT_TRUE(absl::IsResourceExhausted(record.status())) << record.status();
    ASSERT_EQ(ReadFile(path_).value(), bytes_) << room;
  }
  disk_.room.reset();
  EXPECT_TRUE(AppendRecord(*file, kMarker, 5, -5, BodyOf(5)).ok());
  EXPECT_EQ(Read(*file), (Sequences{1, 2, 3, 4, 5}));
}

TEST_F(RecordLogTest, BytesThatCannotBeReadAreDamageUnlessTheyMayHoldTheEnd) {
  const auto file = With(bytes_ + std::string(1 << 17, '\0') + bytes_.substr(ends_[0]));
  disk_.bad_from = static_cast<off_t>(ends_[2] + 5);
  disk_.bad_to = static_cast<off_t>(ends_[2] + 6);
  EXPECT_EQ(Read(*file), (Sequences{1, 2, 1, 2, 3, 4}));
  disk_.bad_to = static_cast<off_t>(file->size());
  EXPECT_TRUE(absl::IsUnavailable(Find(*file).status())) << "what is unread is not cut off";
}

}  // namespace
}  // namespace isthmus::io
