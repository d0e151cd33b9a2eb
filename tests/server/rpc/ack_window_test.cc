// The hand-over of acknowledgements: bounded, in order, never waiting on the pipeline's side.
#include "server/rpc/scans/ack_window.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

namespace isthmus::rpc {
namespace {

ScanAck Ack(uint64_t sequence, uint64_t durable = 0) {
  ScanAck ack;
  ack.sequence = sequence;
  ack.durable_sequence = durable;
  return ack;
}

TEST(AckWindowTest, RoomComesBackWhenAnAckIsTakenNotWhenItArrives) {
  AckWindow window(1);
  ASSERT_TRUE(window.WaitForRoom());
  window.Expect(1);
  window.Add(Ack(1));
  bool taken = false;
  std::thread writer([&] {
    taken = window.Next().has_value();  // Before this, WaitForRoom may not return.
  });
  EXPECT_TRUE(window.WaitForRoom());
  writer.join();
  EXPECT_TRUE(taken);
}

TEST(AckWindowTest, EndsWhenEveryExpectedAckIsOut) {
  AckWindow window(4);
  window.Expect(1);
  window.Expect(2);
  window.EndScans();
  window.Add(Ack(1));
  EXPECT_EQ(window.Next()->sequence, 1u);
  std::thread pipeline([&] { window.Add(Ack(2)); });
  EXPECT_EQ(window.Next()->sequence, 2u);
  EXPECT_FALSE(window.Next().has_value());
  pipeline.join();
}

TEST(AckWindowTest, AWithdrawnScanIsNotWaitedFor) {
  AckWindow window(4);
  window.Expect(1);
  window.Expect(2);
  window.Withdraw(2);
  window.Add(Ack(1));
  window.EndScans();
  EXPECT_EQ(window.Next()->sequence, 1u);
  EXPECT_FALSE(window.Next().has_value());
}

TEST(AckWindowTest, AcksOfAnEarlierStreamOnlyMoveTheDurableSequence) {
  AckWindow window(4);
  window.Add(Ack(7, 3));
  window.Add(Ack(8, 5));
  const auto ack = window.Next();
  ASSERT_TRUE(ack.has_value());
  EXPECT_EQ(ack->sequence, 0u);
  EXPECT_EQ(ack->durable_sequence, 5u);
  window.EndScans();
  EXPECT_FALSE(window.Next().has_value());
}

TEST(AckWindowTest, AScanSentAgainIsAcknowledgedOnceThoughTheEarlierStreamsAckComesFirst) {
  AckWindow window(4);
  window.Expect(5);
  window.Add(Ack(5));  // Of the earlier stream's scan 5.
  window.Add(Ack(5));  // Of this stream's: a duplicate.
  window.EndScans();
  EXPECT_EQ(window.Next()->sequence, 5u);
  EXPECT_EQ(window.Next()->sequence, 0u);
  EXPECT_FALSE(window.Next().has_value());
  // Had the pipeline refused it after that, nothing would be left to withdraw.
  window.Withdraw(5);
}

TEST(AckWindowTest, OnlyARejectionTakesTheReaderReason) {
  AckWindow window(4);
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

TEST(AckWindowTest, StopRefusesFurtherScansAndLetsTheRestOut) {
  AckWindow window(4);
  window.Expect(1);
  window.Stop();
  EXPECT_FALSE(window.WaitForRoom());
  window.Add(Ack(1));
  EXPECT_EQ(window.Next()->sequence, 1u);
  EXPECT_FALSE(window.Next().has_value());
}

TEST(AckWindowTest, CloseWakesBothSides) {
  AckWindow window(1);
  window.Expect(1);
  std::thread reader([&] { EXPECT_FALSE(window.WaitForRoom()); });
  std::thread writer([&] { EXPECT_FALSE(window.Next().has_value()); });
  window.Close();
  reader.join();
  writer.join();
  window.Add(Ack(1));
  EXPECT_FALSE(window.Next().has_value());
}

}  // namespace
}  // namespace isthmus::rpc
