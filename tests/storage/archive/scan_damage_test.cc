// Archives of scans after crashes, power cuts and years on a disk.
#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "core/byte_stream.h"
#include "core/io/crc32c.h"
#include "storage/archive/scan_archive.h"
#include "storage/archive/scan_segment.h"
#include "tests/storage/scans.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::storage {
namespace {

const SessionId kDamaged("alice-1");
const ScanArchiveOptions kQuick{.disk = WithSync(DoNotSync)};

// An archive whose scans are all in one segment.
class OneSegment {
 public:
  explicit OneSegment(uint64_t scans) {
    const auto archive = ScanArchive::Open(folder_.path(), kQuick).value();
    std::filesystem::path file = path();
    for (uint64_t i = 1; i <= scans; ++i) {
      EXPECT_TRUE(archive->Append(kDamaged, MakeUpload(i)).ok());
      ends_.push_back(std::filesystem::file_size(file));
    }
    bytes_ = Bytes(path());
  }

  const std::string& directory() const { return folder_.path(); }
  std::string path() const { return folder_.path() + "/scans/alice-1/000001.scans"; }
  const std::string& bytes() const { return bytes_; }
  uint64_t end(uint64_t sequence) const {
    return sequence == 0 ? kSegmentHeadSize : ends_[sequence - 1];
  }
  ReadBack Read() const { return ReadScans(directory(), kDamaged); }
  void Append(uint64_t first, uint64_t last) const {
    const auto archive = ScanArchive::Open(directory(), kQuick).value();
    for (uint64_t i = first; i <= last; ++i) {
      ASSERT_TRUE(archive->Append(kDamaged, MakeUpload(i)).ok());
    }
  }

 private:
  TemporaryFolder folder_;
  std::vector<uint64_t> ends_;
  std::string bytes_;
};

TEST(ScanDamageTest, ARecordTornAnywhereIsCutOff) {
  const OneSegment archive(3);
  for (uint64_t size = archive.end(2); size < archive.end(3); ++size) {
    WriteBytes(archive.path(), archive.bytes().substr(0, size));
    ReadBack back = archive.Read();
    ASSERT_EQ(back.sequences, Range(1, 2)) << size;
    ASSERT_EQ(back.damaged, 0) << size;
    ASSERT_EQ(back.unfinished_bytes, size - archive.end(2));
    archive.Append(3, 4);
    back = archive.Read();
    ASSERT_EQ(back.sequences, Range(1, 4)) << size;
    ASSERT_EQ(back.damaged, 0) << size;
    ASSERT_EQ(back.unfinished_bytes, 0u);
  }
}

TEST(ScanDamageTest, ASegmentTornInItsHeadIsBegunAnew) {
  const OneSegment archive(1);
  for (uint64_t size = 0; size <= kSegmentHeadSize; ++size) {
    WriteBytes(archive.path(), archive.bytes().substr(0, size));
    EXPECT_TRUE(archive.Read().sequences.empty());
    archive.Append(1, 2);
    const ReadBack back = archive.Read();
    ASSERT_EQ(back.sequences, Range(1, 2)) << size;
    ASSERT_EQ(back.damaged, 0);
  }
}

// A file that had grown when the power went, while what was to be in it had not come.
TEST(ScanDamageTest, ZerosInPlaceOfTheLastRecordAreCutOff) {
  const OneSegment archive(3);
  for (uint64_t from = archive.end(2); from < archive.end(3); from += 7) {
    std::string bytes = archive.bytes();
    std::memset(bytes.data() + from, 0, bytes.size() - from);
    WriteBytes(archive.path(), bytes);
    archive.Append(4, 4);
    const ReadBack back = archive.Read();
    // The last bytes of a record may be zeros as it is.
    const bool is_whole = bytes == archive.bytes();
    ASSERT_EQ(back.sequences, is_whole ? Range(1, 4) : (std::vector<uint64_t>{1, 2, 4})) << from;
    ASSERT_EQ(back.damaged, 0) << from;
  }
}

TEST(ScanDamageTest, AFlippedBitCostsOneScan) {
  const OneSegment archive(4);
  for (uint64_t at = archive.end(1); at < archive.end(2); ++at) {
    std::string bytes = archive.bytes();
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << (at % 8)));
    WriteBytes(archive.path(), bytes);
    const ReadBack back = archive.Read();
    ASSERT_EQ(back.sequences, (std::vector<uint64_t>{1, 3, 4})) << at;
    ASSERT_EQ(back.damaged, 1) << at;
  }
}

TEST(ScanDamageTest, AFlippedBitInTheHeadOfASegmentCostsNothing) {
  const OneSegment archive(3);
  for (uint64_t at = 0; at < kSegmentHeadSize; ++at) {
    std::string bytes = archive.bytes();
    bytes[at] = static_cast<char>(bytes[at] ^ 4);
    WriteBytes(archive.path(), bytes);
    const ReadBack back = archive.Read();
    ASSERT_EQ(back.sequences, Range(1, 3)) << at;
    ASSERT_EQ(back.damaged, 1) << at;
  }
}

TEST(ScanDamageTest, DamageInTheMiddleIsNoReasonToCutOffWhatFollows) {
  const OneSegment archive(5);
  std::string bytes = archive.bytes();
  bytes[archive.end(2) + 10] ^= 1;  // Its head: the record's length cannot be read.
  WriteBytes(archive.path(), bytes);
  archive.Append(6, 7);
  ReadBack back = archive.Read();
  EXPECT_EQ(back.sequences, (std::vector<uint64_t>{1, 2, 4, 5, 6, 7}));
  EXPECT_EQ(back.damaged, 1);
  archive.Append(3, 3);  // Sent again: in its place.
  back = archive.Read();
  EXPECT_EQ(back.sequences, Range(1, 7));
}

TEST(ScanDamageTest, ADamagedScanIsReadFromItsCopy) {
  const OneSegment archive(5);
  archive.Append(3, 6);
  std::string bytes = Bytes(archive.path());
  bytes[archive.end(3) - 1] ^= 1;
  WriteBytes(archive.path(), bytes);
  const ReadBack back = archive.Read();
  EXPECT_EQ(back.sequences, Range(1, 6));
  EXPECT_EQ(back.damaged, 1);
}

// Any bytes at all: no crash, and no scan but those that were put in.
TEST(ScanDamageTest, NoiseIsNoScan) {
  std::mt19937 random(5);
  const OneSegment archive(3);
  for (int round = 0; round < 200; ++round) {
    std::string bytes = archive.bytes();
    const size_t from = random() % bytes.size();
    const size_t size = std::min<size_t>(bytes.size() - from, random() % 300);
    for (size_t i = 0; i < size; ++i) bytes[from + i] = static_cast<char>(random());
    if (round % 2 == 0) bytes.resize(random() % bytes.size());
    WriteBytes(archive.path(), bytes);
    ReadBack back = archive.Read();  // ReadScans compares the scans found.
    EXPECT_LE(back.sequences.size(), 3u);
    archive.Append(1, 4);
    back = archive.Read();
    EXPECT_EQ(back.sequences, Range(1, 4)) << round;
  }
}

TEST(ScanDamageTest, ANewerFormatIsRefusedAndLeftAsItIs) {
  const OneSegment archive(2);
  std::string bytes = archive.bytes();
  bytes[8] = 9;
  const std::string head = bytes.substr(0, 12);
  std::string checksum;
  AppendBytes(io::Crc32c(head.data(), head.size()), checksum);
  bytes.replace(12, 4, checksum);
  WriteBytes(archive.path(), bytes);
  EXPECT_TRUE(absl::IsFailedPrecondition(ScanReader::Open(archive.directory(), kDamaged).status()));
  const auto writer = ScanArchive::Open(archive.directory(), kQuick).value();
  EXPECT_TRUE(absl::IsFailedPrecondition(writer->Append(kDamaged, MakeUpload(3))));
  EXPECT_EQ(Bytes(archive.path()), bytes);
}

// The power goes: each sector that was not synced survives or does not. Robots send again all that
// was not durable.
TEST(ScanDamageTest, PowerCuts) {
  std::mt19937 random(11);
  TemporaryFolder folder;
  const std::string path = folder.path() + "/scans/alice-1/";
  uint64_t durable = 0;
  std::string last;  // The file that was synced last, and how much of it.
  size_t synced_size = 0;
  for (int cut = 0; cut < 60; ++cut) {
    ScanArchiveOptions options = kQuick;
    options.segment_bytes = 6000;
    auto archive = ScanArchive::Open(folder.path(), options).value();
    uint64_t sent = durable;
    for (int i = 0; i < static_cast<int>(random() % 30); ++i) {
      ASSERT_TRUE(archive->Append(kDamaged, MakeUpload(++sent)).ok());
      if (random() % 4 != 0) continue;
      ASSERT_TRUE(archive->Sync(kDamaged).ok());
      durable = sent;
      last = path + SegmentName(ListSegments(path).back());
      synced_size = Bytes(last).size();
    }
    archive = nullptr;
    if (ListSegments(path).empty()) continue;
    const std::string file = path + SegmentName(ListSegments(path).back());
    std::string bytes = Bytes(file);
    for (size_t at = file == last ? synced_size : 0; at < bytes.size();) {
      const size_t end = std::min(bytes.size(), (at / 512 + 1) * 512);
      if (random() % 2 == 0) std::memset(bytes.data() + at, 0, end - at);
      at = end;
    }
    WriteBytes(file, bytes);
    const ReadBack back = ReadScans(folder.path(), kDamaged);
    ASSERT_GE(back.sequences.size(), durable);
    ASSERT_EQ(std::vector<uint64_t>(back.sequences.begin(), back.sequences.begin() + durable),
              Range(1, durable));
  }
  EXPECT_GT(durable, 100u);
}

}  // namespace
}  // namespace isthmus::storage
