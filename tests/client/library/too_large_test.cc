// Scans above the limit of the server's messages: a spool sets them aside and goes on; a stream
// without one ends with an error that names the setting.
#include <absl/strings/str_split.h>

#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "client/library/spool/set_aside.h"
#include "core/io/file_io.h"
#include "tests/client/library/spooled_stream_fixture.h"

namespace isthmus::client {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class TooLargeTest : public SpooledStreamTest {
 protected:
  TooLargeTest() {
    server_.Stop();
    server_.max_message_bytes = 10'000;
    server_.Start();
  }

  // Larger than the server takes, whatever is made of it.
  static PointPayload Large() {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> coordinate(-50, 50);
    Cloud cloud;
    for (int i = 0; i < 2000; ++i) {
      cloud.push_back({coordinate(random), coordinate(random), coordinate(random), 0});
    }
    return codec::MakePayload(cloud);
  }
  absl::Status PushLarge(ScanStream& stream) {
    ++pushed_;
    return stream.Push(static_cast<int64_t>(pushed_) * kPeriodNs, Large());
  }
};

TEST_F(TooLargeTest, AScanOfASpoolIsSetAsideAndTheSpoolGoesOn) {
  server_.durable_every = 1;
  auto stream = Open();
  Push(*stream, 2);
  ASSERT_TRUE(PushLarge(*stream).ok());
  Push(*stream, 2);
  ASSERT_TRUE(PushLarge(*stream).ok());
  Push(*stream, 1);
  const auto session = stream->FinishSession();
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(stream->stats().set_aside, 2u);
  EXPECT_EQ(stream->stats().lost, 0u);
  EXPECT_EQ(stream->stats().backlog, 0u);

  // Its number is used up, so that those behind it could follow.
  const auto scans = server_.sessions()["alice-1"].scans;
  ASSERT_EQ(scans.size(), 7u);
  for (const uint64_t k : {1, 2, 4, 5, 7}) {
    EXPECT_EQ(scans[k - 1].cloud().data(), PayloadOf(k).data);
  }
  EXPECT_TRUE(scans[2].cloud().data().empty());
  EXPECT_EQ(scans[2].end_stamp_ns(), 3 * kPeriodNs);

  // Scans that were acknowledged to the robot are on its disk still, as they were.
  const std::string path =
      options_.spool_dir + "/too-large/" + std::to_string(3 * kPeriodNs) + ".scan";
  v1::ScanMessage kept;
  ASSERT_TRUE(kept.ParseFromString(*io::ReadFile(path)));
  EXPECT_EQ(kept.cloud().data(), Large().data);
  EXPECT_EQ(kept.end_stamp_ns(), 3 * kPeriodNs);
  EXPECT_THAT(events(), AllOf(HasSubstr("larger than the 10000 that the server takes"),
                              HasSubstr("network.max_receive_bytes"), HasSubstr(path)));
}

TEST_F(TooLargeTest, ManyAreCountedAndNotToldOneByOne) {
  std::vector<std::string> reasons;
  Mutex mutex;
  options_.on_ack = [&](const ScanAck& ack) {
    MutexLock lock(&mutex);
    reasons.push_back(ack.reason);
  };
  auto stream = Open();
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(PushLarge(*stream).ok());
  ASSERT_TRUE(stream->FinishSession().ok());
  EXPECT_EQ(stream->stats().set_aside, 5u);
  const std::vector<std::string> told = absl::StrSplit(events(), "set aside in");
  EXPECT_EQ(told.size(), 4u) << events();
  MutexLock lock(&mutex);
  ASSERT_EQ(reasons.size(), 5u);
  for (const std::string& reason : reasons) {
    EXPECT_THAT(reason, HasSubstr("network.max_receive_bytes"));
  }
}

TEST_F(TooLargeTest, AServerThatTakesMoreIsSentMore) {
  {
    auto stream = Open();
    ASSERT_TRUE(PushLarge(*stream).ok());
    ASSERT_TRUE(stream->Finish().ok());
    EXPECT_EQ(stream->stats().set_aside, 1u);
  }
  auto stream = Open();
  Push(*stream, 1);
  server_.WaitForScans("alice-1", 2);
  server_.Stop();
  server_.max_message_bytes = 1 << 20;
  server_.Start();
  ASSERT_TRUE(PushLarge(*stream).ok());
  ASSERT_TRUE(stream->FinishSession().ok());
  EXPECT_EQ(stream->stats().set_aside, 0u);
  const auto scans = server_.sessions()["alice-1"].scans;
  ASSERT_EQ(scans.size(), 3u);
  EXPECT_EQ(scans[2].cloud().data(), Large().data);
}

TEST_F(TooLargeTest, AStreamWithoutASpoolEndsWithWhatToDo) {
  options_.spool_dir.clear();
  const auto session = client_->CreateSession("alice", "vlp16");
  ASSERT_TRUE(session.ok()) << session.status();
  auto stream = client_->OpenScanStream(session->record.id, options_);
  ASSERT_TRUE(stream.ok()) << stream.status();
  ASSERT_TRUE((*stream)->Push(1, Large()).ok());
  const absl::Status status = (*stream)->Finish();
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_THAT(std::string(status.message()), AllOf(HasSubstr("larger than the server takes"),
                                                   HasSubstr("network.max_receive_bytes")));
}

TEST(SetAsideTest, KeepsNoMoreThanItMay) {
  SpoolFiles files;
  ASSERT_TRUE(SetAside(files.path(), 1, std::string(60, 'a'), 100).ok());
  const auto second = SetAside(files.path(), 2, std::string(60, 'b'), 100);
  EXPECT_TRUE(absl::IsResourceExhausted(second.status())) << second.status();
  // The same again takes no more room than before.
  EXPECT_TRUE(SetAside(files.path(), 1, std::string(60, 'a'), 100).ok());
}

}  // namespace
}  // namespace isthmus::client
