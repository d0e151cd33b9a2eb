#include "client/console/taken_scans.h"

#include <absl/status/status.h>
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

// As where the spool has not kept its last scan.
std::optional<bool> NotKnown(const readers::RecordedScan&) { return std::nullopt; }
bool NeverStopped() { return false; }

// The scans that are taken for taken, of those that can be read.
uint64_t CountTaken(const RobotScans& robot, const client::SpoolState& spool) {
  TakenScans taken(robot, spool, NotKnown, NeverStopped);
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

TEST(TakenScans, AreToldByTheirContentWhereThatIsKept) {
  client::SpoolState spool;
  spool.last_stamp_ns = StampOf(25);
  spool.last_sequence = 24;
  const auto has_it = [](const readers::RecordedScan&) { return true; };
  const auto has_it_not = [](const readers::RecordedScan&) { return false; };
  TakenScans own(Readable(), spool, has_it, NeverStopped);
  EXPECT_TRUE(own.status().ok()) << own.status();
  TakenScans other(Readable(), spool, has_it_not, NeverStopped);
  EXPECT_TRUE(absl::IsFailedPrecondition(other.status())) << other.status();
  // A part of the recording that begins behind its first scans has fewer before the last.
  spool.last_sequence = 40;
  TakenScans part(Readable(), spool, has_it, NeverStopped);
  EXPECT_TRUE(part.status().ok()) << part.status();
}

TEST(TakenScans, OfAnotherRecordingGoOnOnlyWhereItIsLater) {
  client::SpoolState spool;
  spool.last_stamp_ns = StampOf(25) + 1;
  spool.last_sequence = 25;
  EXPECT_TRUE(
      absl::IsFailedPrecondition(TakenScans(Readable(), spool, NotKnown, NeverStopped).status()));
  spool.last_stamp_ns = 1;
  TakenScans later(Readable(), spool, NotKnown, NeverStopped);
  EXPECT_TRUE(later.status().ok()) << later.status();
  EXPECT_FALSE(later.Take(StampOf(1)));
}

// A spool that lost its end: 25 scans are in it, and the server has 40.
TEST(TakenScans, OfADamagedSpoolAreComparedWithTheServersEnd) {
  client::SpoolState spool;
  spool.last_stamp_ns = StampOf(25);
  spool.last_sequence = 24;
  const auto status = [&spool](int64_t ahead, uint64_t end, uint64_t poseless, uint64_t late = 0) {
    spool.server_ahead = ahead;
    return TakenScans(Readable(), spool, NotKnown, NeverStopped,
                      ServerEnd{StampOf(end), poseless, late})
        .status();
  };
  for (const int64_t ahead : {15, -5}) {
    const uint64_t end = static_cast<uint64_t>(25 + ahead);
    EXPECT_TRUE(status(ahead, end, 0).ok()) << status(ahead, end, 0);
    EXPECT_TRUE(status(ahead, end - 12, 0).ok()) << "poses may be to come";
    EXPECT_TRUE(absl::IsFailedPrecondition(status(ahead, end + 12, 0)));
    EXPECT_TRUE(status(ahead, end + 2, 0, 2).ok());
  }
  EXPECT_TRUE(absl::IsFailedPrecondition(status(kTaped, kTaped, kTaped))) << "it is too short";
  EXPECT_TRUE(status(15, 5, 18).ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(status(15, 5, 17)));
  // If nothing is left, the recording's first scan is the session's.
  spool = {};
  EXPECT_TRUE(status(39, 40, 0).ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(status(30, 40, 0)));
}

TEST(TakenScans, AreToldByTheirStampsWhereTheRecordingCanBeReadOnce) {
  client::SpoolState spool;
  spool.last_stamp_ns = StampOf(25);
  spool.last_sequence = 25;
  TakenScans unread(RobotScans(), spool, NotKnown, NeverStopped);
  EXPECT_TRUE(unread.status().ok()) << unread.status();
  EXPECT_TRUE(unread.Take(spool.last_stamp_ns));
  EXPECT_FALSE(unread.Take(spool.last_stamp_ns + 1));
  EXPECT_EQ(unread.by_stamp(), 1u);
}

}  // namespace
}  // namespace isthmus::cli
