// The hand-over of acknowledgements: bounded in scans and bytes, in order, never waiting.
#include "server/rpc/scans/ack_window.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace isthmus::rpc {
namespace {

ScanAck Ack(uint64_t sequence, uint64_t durable = 0) {
  ScanAck ack;
  ack.sequence = sequence;
  ack.durable_sequence = durable;
  return ack;
}

AckWindow::Limits Scans(size_t scans) { return {.scans = scans}; }

TEST(AckWindowTest, RoomComesBackWhenAnAckIsTakenNotWhenItArrives) {
  AckWindow window(Scans(1), nullptr);
  EXPECT_TRUE(window.HasRoom());
  window.Expect(1);
  EXPECT_FALSE(window.HasRoom());
  window.Add(Ack(1));
  EXPECT_FALSE(window.HasRoom());
  EXPECT_EQ(window.Next()->sequence, 1u);
  EXPECT_TRUE(window.HasRoom());
}

TEST(AckWindowTest, BytesBoundItTooButForOneScan) {
  ByteBudget budget(1000);
  AckWindow window({.scans = 10, .bytes = 100}, nullptr);
  window.Expect(1, "", budget.Ask(60, nullptr));
  EXPECT_TRUE(window.HasRoom());
  window.Expect(2, "", budget.Ask(60, nullptr));
  EXPECT_FALSE(window.HasRoom());
  window.Add(Ack(1));
  EXPECT_TRUE(window.HasRoom());
  EXPECT_EQ(budget.used(), 60u);
  window.Withdraw(2);
  EXPECT_EQ(budget.used(), 0u);
  window.Expect(3, "", budget.Ask(600, nullptr));
  EXPECT_FALSE(window.HasRoom());
  window.Close();
  EXPECT_EQ(budget.used(), 0u);
}

TEST(AckWindowTest, EndsWhenEveryExpectedAckIsOut) {
  AckWindow window(Scans(4), nullptr);
  window.Expect(1);
  window.Expect(2);
  EXPECT_FALSE(window.drained());
  window.EndScans();
  window.Add(Ack(1));
  EXPECT_EQ(window.Next()->sequence, 1u);
  EXPECT_FALSE(window.Next().has_value());
  EXPECT_FALSE(window.drained());
  window.Add(Ack(2));
  EXPECT_FALSE(window.drained());
  EXPECT_EQ(window.Next()->sequence, 2u);
  EXPECT_TRUE(window.drained());
}

TEST(AckWindowTest, AWithdrawnScanIsNotWaitedFor) {
  AckWindow window(Scans(4), nullptr);
  window.Expect(1);
  window.Expect(2);
  window.Withdraw(2);
  window.Add(Ack(1));
  window.EndScans();
  EXPECT_EQ(window.Next()->sequence, 1u);
  EXPECT_TRUE(window.drained());
}

TEST(AckWindowTest, AcksOfAnEarlierStreamOnlyMoveTheDurableSequence) {
  AckWindow window(Scans(4), nullptr);
  window.Add(Ack(7, 3));
  window.Add(Ack(8, 5));
  const auto ack = window.Next();
  ASSERT_TRUE(ack.has_value());
  EXPECT_EQ(ack->sequence, 0u);
  EXPECT_EQ(ack->durable_sequence, 5u);
  EXPECT_FALSE(window.Next().has_value());
}

TEST(AckWindowTest, AScanSentAgainIsAcknowledgedOnceThoughTheEarlierStreamsAckComesFirst) {
  AckWindow window(Scans(4), nullptr);
  window.Expect(5);
  window.Add(Ack(5));  // The earlier stream's scan 5.
  window.Add(Ack(5));  // This stream's scan 5, a duplicate.
  window.EndScans();
  EXPECT_EQ(window.Next()->sequence, 5u);
  EXPECT_EQ(window.Next()->sequence, 0u);
  EXPECT_TRUE(window.drained());
  // Had the pipeline refused it after that, nothing would be left to withdraw.
  window.Withdraw(5);
}

TEST(AckWindowTest, OnlyARejectionTakesTheReaderReason) {
  AckWindow window(Scans(4), nullptr);
  window.Expect(1, "no encoding");
  window.Expect(2, "no encoding");
  ScanAck rejected = Ack(1);
  rejected.outcome = ScanOutcome::kRejected;
  rejected.reason = "empty";
  window.Add(rejected);
  ScanAck duplicate = Ack(2);
  duplicate.outcome = ScanOutcome::kDuplicate;
  window.Add(duplicate);
  EXPECT_EQ(window.Next()->reason, "no encoding");
  EXPECT_EQ(window.Next()->reason, "");
}

TEST(AckWindowTest, ClosedItHoldsNothing) {
  AckWindow window(Scans(4), nullptr);
  window.Expect(1);
  window.Expect(2);
  window.Add(Ack(1));
  window.Close();
  EXPECT_FALSE(window.HasRoom());
  EXPECT_TRUE(window.drained());
  window.Add(Ack(2));
  EXPECT_FALSE(window.Next().has_value());
}

TEST(AckWindowTest, TellsOfWhatComesFromOutside) {
  int told = 0;
  AckWindow window(Scans(4), [&told] { ++told; });
  window.Expect(1);
  EXPECT_EQ(told, 0);
  window.Add(Ack(1));
  EXPECT_EQ(told, 1);
  window.Close();
  EXPECT_EQ(told, 2);
  window.Add(Ack(2));
  EXPECT_EQ(told, 2);
}

}  // namespace
}  // namespace isthmus::rpc
