#include "client/library/stream/scan_window.h"

#include <gtest/gtest.h>

#include <vector>

namespace isthmus::client {
namespace {

constexpr size_t kBytes = 10;  // Bytes of every scan.

// A scan is its own number, counted from 1.
using Window = ScanWindow<uint64_t>;

void Add(Window& window, uint64_t count) {
  for (uint64_t i = 1; i <= count; ++i) window.Add(std::make_shared<uint64_t>(i), kBytes);
}

// The first scan has the number behind `before`.
std::vector<uint64_t> SendAll(Window& window, uint64_t before = 0) {
  std::vector<uint64_t> sent;
  for (;;) {
    const auto [scan, sequence] = window.TakeUnsent();
    if (scan == nullptr) return sent;
    EXPECT_EQ(before + *scan, sequence);
    sent.push_back(sequence);
  }
}

using Sequences = std::vector<uint64_t>;

TEST(ScanWindow, IsFullUntilTheOldestIsAcknowledged) {
  Window window(1, 3, 1000);
  Add(window, 3);
  EXPECT_TRUE(window.full());
  EXPECT_EQ(SendAll(window), (Sequences{1, 2, 3}));
  EXPECT_TRUE(window.Ack(1));
  EXPECT_FALSE(window.full());
  EXPECT_FALSE(window.all_acked());
  EXPECT_TRUE(window.Ack(2));
  EXPECT_TRUE(window.Ack(3));
  EXPECT_TRUE(window.all_acked());
}

TEST(ScanWindow, ReportsEveryAcknowledgementOnce) {
  Window window(1, 8, 1000);
  Add(window, 2);
  SendAll(window);
  EXPECT_TRUE(window.Ack(1));
  EXPECT_FALSE(window.Ack(1));
  EXPECT_FALSE(window.Ack(7)) << "never sent";
}

TEST(ScanWindow, SendsAgainWhatWasNotAcknowledged) {
  Window window(1, 8, 1000);
  Add(window, 4);
  SendAll(window);
  window.Ack(1);
  window.Rewind(3);  // The acknowledgements of 2 and 3 were lost.
  EXPECT_EQ(SendAll(window), (Sequences{2, 3, 4}));
}

TEST(ScanWindow, SendsAgainWhatACrashedServerLost) {
  Window window(1, 8, 1000);
  Add(window, 4);
  SendAll(window);
  for (uint64_t i = 1; i <= 4; ++i) window.Ack(i);
  window.Durable(1);
  window.Rewind(1);
  EXPECT_EQ(SendAll(window), (Sequences{2, 3, 4}));
  EXPECT_FALSE(window.Ack(2)) << "the robot has heard of it";
  EXPECT_TRUE(window.all_acked());
}

TEST(ScanWindow, DurableScansAreNotKept) {
  Window window(1, 8, 1000);
  Add(window, 4);
  SendAll(window);
  window.Ack(1);
  window.Ack(2);
  window.Durable(3);  // 3 has not been acknowledged: its outcome is still to be told.
  window.Rewind(0);
  EXPECT_EQ(SendAll(window), (Sequences{3, 4}));
}

TEST(ScanWindow, TheSpoolGivesUpTheOldestAcknowledgedOnly) {
  Window window(1, 8, 2 * kBytes);
  Add(window, 8);
  SendAll(window);
  for (uint64_t i = 1; i <= 5; ++i) window.Ack(i);
  window.Rewind(0);
  EXPECT_EQ(SendAll(window), (Sequences{4, 5, 6, 7, 8}));
}

TEST(ScanWindow, ContinuesASessionWhereItStands) {
  Window window(41, 8, 1000);
  EXPECT_TRUE(window.all_acked());
  Add(window, 2);
  window.Rewind(40);
  EXPECT_EQ(SendAll(window, 40), (Sequences{41, 42}));
  EXPECT_TRUE(window.Ack(41));
}

TEST(ScanWindow, ScansHaveTheirNumbersFromWhenTheyAreSent) {
  Window window(41, 8, 1000);
  Add(window, 2);
  EXPECT_EQ(window.sent(), std::nullopt);
  window.Renumber(45);
  EXPECT_EQ(SendAll(window, 45), (Sequences{46, 47}));
  EXPECT_FALSE(window.Ack(41));
  EXPECT_TRUE(window.Ack(46));
  window.Rewind(40);
  EXPECT_EQ(window.sent(), 47u) << "ever";
}

}  // namespace
}  // namespace isthmus::client
