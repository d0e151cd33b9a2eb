// Effects of a crash or a bad disk on a file of scans.
#include "client/library/spool/spool_segment.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "tests/client/library/spool_files.h"

namespace isthmus::client {
namespace {

constexpr int kScans = 5;

std::string DottedPayload(uint64_t sequence) {
  return "scan " + std::to_string(sequence) + std::string(sequence, '.');
}

class SpoolSegmentTest : public testing::Test {
 protected:
  // A file with scans 7 to 11; returns its bytes, and where each scan ends.
  std::string MakeFile(std::vector<uint64_t>* ends) {
    auto segment = SpoolSegment::Create(path_, {"owner", 7, 60}, io::DiskCalls::System());
    EXPECT_TRUE(segment.ok()) << segment.status();
    ends->push_back((*segment)->bytes());
    for (uint64_t i = 7; i < 7 + kScans; ++i) {
      EXPECT_TRUE((*segment)->Append(i, static_cast<int64_t>(10 * i), DottedPayload(i)).ok());
      ends->push_back((*segment)->bytes());
    }
    return ReadFile(path_);
  }

  std::shared_ptr<SpoolSegment> Open() {
    auto segment = SpoolSegment::Open(path_, {"owner", 7, 0}, io::DiskCalls::System());
    EXPECT_TRUE(segment.ok()) << segment.status();
    return *segment;
  }

  SpoolFiles files_;
  const std::string path_ = files_.path() + "/a.scans";
};

TEST_F(SpoolSegmentTest, WhatWasWrittenIsFoundAndRead) {
  std::vector<uint64_t> ends;
  MakeFile(&ends);
  const auto segment = Open();
  EXPECT_EQ(segment->header().owner, "owner");
  EXPECT_EQ(segment->header().first_sequence, 7u);
  EXPECT_EQ(segment->header().stamp_before_ns, 60);
  const auto contents = segment->Find(io::Look::kBodies);
  ASSERT_TRUE(contents.ok());
  ASSERT_EQ(contents->records.size(), static_cast<size_t>(kScans));
  EXPECT_TRUE(contents->damaged.empty());
  EXPECT_EQ(contents->end, ends.back());
  for (const io::Record& scan : contents->records) {
    EXPECT_EQ(scan.stamp_ns, static_cast<int64_t>(10 * scan.sequence));
    const auto payload = segment->Read(scan);
    ASSERT_TRUE(payload.ok());
    EXPECT_EQ(*payload, DottedPayload(scan.sequence));
  }
}

TEST_F(SpoolSegmentTest, AFlippedByteCostsAtMostItsOwnScan) {
  std::vector<uint64_t> ends;
  const std::string whole = MakeFile(&ends);
  for (size_t at = 0; at < whole.size(); ++at) {
    std::string flipped = whole;
    flipped[at] = static_cast<char>(flipped[at] ^ 0x40);
    WriteFile(path_, flipped);
    const auto segment = SpoolSegment::Open(path_, {"owner", 7, 0}, io::DiskCalls::System());
    ASSERT_TRUE(segment.ok()) << "flipped at " << at << ": " << segment.status();
    const auto contents = (*segment)->Find(io::Look::kBodies);
    ASSERT_TRUE(contents.ok());
    const size_t expected = at < ends[0] ? kScans : kScans - 1;
    ASSERT_EQ(contents->records.size(), expected) << "flipped at " << at;
    for (const io::Record& scan : contents->records) {
      const auto payload = (*segment)->Read(scan);
      ASSERT_TRUE(payload.ok());
      EXPECT_EQ(*payload, DottedPayload(scan.sequence));
    }
  }
}

TEST_F(SpoolSegmentTest, AFullDiskLeavesNoEmptyFile) {
  FailingDisk disk;
  disk.room = 3;
  EXPECT_TRUE(absl::IsResourceExhausted(
      SpoolSegment::Create(path_, {"owner", 7, 0}, disk.calls()).status()));
  EXPECT_FALSE(std::ifstream(path_).good());
}

}  // namespace
}  // namespace isthmus::client
