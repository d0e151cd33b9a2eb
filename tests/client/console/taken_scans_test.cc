#include "client/console/taken_scans.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>

namespace isthmus::cli {
namespace {

constexpr uint64_t kTaped = 60;

// Scan i, from 1 on: the clock was set back by a second in the middle, so that stamps come twice.
int64_t StampOf(uint64_t i) {
  const int64_t start_ns = i > 20 ? 99'000'000'000 : 100'000'000'000;
  return start_ns + static_cast<int64_t>(i) * 100'000'000;
}

// The tenth cannot be read.
class SetBackScans final : public readers::ScanReader {
 public:
  absl::StatusOr<std::optional<readers::RecordedScan>> Next() override {
    if (read_ == kTaped) return std::nullopt;
    if (++read_ == 10) return absl::DataLossError("damaged");
    readers::RecordedScan scan;
    scan.end_stamp_ns = StampOf(read_);
    return scan;
  }

 private:
  uint64_t read_ = 0;
};

// The scans that are taken for taken, of those that can be read.
uint64_t CountTaken(const RobotScans& robot, const client::SpoolState& spool) {
  TakenScans taken(robot, spool, [] { return false; });
  uint64_t count = 0;
  for (uint64_t i = 1; i <= kTaped; ++i) {
    if (i != 10) count += taken.Take(StampOf(i)) ? 1 : 0;
  }
  return count;
}

RobotScans Readable() {
  RobotScans robot;
  robot.read_again = [] { return std::make_unique<SetBackScans>(); };
  return robot;
}

TEST(TakenScans, AreThoseUpToTheLastInTheSpoolThoughTheClockWasSetBack) {
  const RobotScans robot = Readable();
  EXPECT_EQ(CountTaken(robot, {}), 0u);
  for (uint64_t i = 1; i <= kTaped; ++i) {
    if (i == 10) continue;
    const uint64_t readable = i < 10 ? i : i - 1;
    client::SpoolState spool;
    spool.last_stamp_ns = StampOf(i);
    spool.last_sequence = readable;
    EXPECT_EQ(CountTaken(robot, spool), readable);
    // One of them could not be sent, and has no number.
    --spool.last_sequence;
    EXPECT_EQ(CountTaken(robot, spool), spool.last_sequence > 0 ? readable : 0) << i;
  }
}

TEST(TakenScans, AreToldByTheirStampsWhereTheLastIsNotInTheRecording) {
  client::SpoolState spool;
  spool.last_stamp_ns = StampOf(25) + 1;
  spool.last_sequence = 25;
  TakenScans taken(Readable(), spool, [] { return false; });
  EXPECT_TRUE(taken.Take(spool.last_stamp_ns - 1));
  EXPECT_FALSE(taken.Take(spool.last_stamp_ns + 1));
  EXPECT_EQ(taken.by_stamp(), 1u);
  // As where the recording can be read but once.
  TakenScans unread(RobotScans(), spool, [] { return false; });
  EXPECT_TRUE(unread.Take(spool.last_stamp_ns));
  EXPECT_FALSE(unread.Take(spool.last_stamp_ns + 1));
}

}  // namespace
}  // namespace isthmus::cli
