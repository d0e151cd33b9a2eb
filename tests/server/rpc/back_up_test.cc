// A backup on its way to the reader: what comes first, what comes last, and who has to wait.
#include "server/rpc/back_up.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "core/io/crc32c.h"
#include "tests/server/rpc/fake_pipeline.h"

namespace isthmus::rpc {
namespace {

class BackUpTest : public testing::Test {
 protected:
  absl::Status Run(const BackupSource& source, size_t reads = 1000) {
    return BackUp(pipeline_, source, busy_, {}, [&](const v1::BackUpResponse& response) {
      if (responses_.size() == reads) return false;
      responses_.push_back(response);
      return true;
    });
  }

  FakePipeline pipeline_;
  std::atomic<bool> busy_ = false;
  std::vector<v1::BackUpResponse> responses_;
};

absl::StatusOr<BackupContents> TwoPieces(const BackupSink& sink) {
  if (!sink.progress(0.5) || !sink.progress(1)) return absl::CancelledError("given up");
  sink.begin(5);
  if (!sink.piece("abc") || !sink.piece("de")) return absl::CancelledError("given up");
  return BackupContents{2, 3, 40, 500, 1, "submap alice-1/3: damaged\n"};
}

TEST_F(BackUpTest, ProgressThenDataThenWhatIsInIt) {
  const absl::Status status = Run(TwoPieces);
  ASSERT_TRUE(status.ok()) << status;
  std::string bytes;
  for (const v1::BackUpResponse& response : responses_) bytes += response.data();
  EXPECT_EQ(bytes, "abcde");
  EXPECT_EQ(responses_.front().copied(), 0.5);
  EXPECT_FALSE(responses_.front().last());
  const v1::BackUpResponse& last = responses_.back();
  EXPECT_TRUE(last.last());
  EXPECT_EQ(last.size(), 5u);
  EXPECT_EQ(last.crc32c(), io::Crc32c("abcde", 5, 0));
  EXPECT_EQ(last.contents().submaps(), 3);
  EXPECT_EQ(last.contents().damaged(), 1);
  EXPECT_EQ(last.contents().report(), "submap alice-1/3: damaged\n");
}

TEST_F(BackUpTest, AReaderThatIsGoneEndsIt) {
  for (size_t reads = 0; reads < 5; ++reads) {
    responses_.clear();
    EXPECT_TRUE(absl::IsCancelled(Run(TwoPieces, reads))) << reads;
  }
}

TEST_F(BackUpTest, FailuresOfTheSourceReachTheReader) {
  const absl::Status status = Run([](const BackupSink&) -> absl::StatusOr<BackupContents> {
    return absl::ResourceExhaustedError("disk full");
  });
  EXPECT_TRUE(absl::IsResourceExhausted(status));
  EXPECT_TRUE(absl::IsUnimplemented(Run(nullptr)));
}

TEST_F(BackUpTest, OneAtATime) {
  absl::Status second;
  const absl::Status first = Run([&](const BackupSink& sink) {
    std::thread other([&] {
      second =
          BackUp(pipeline_, TwoPieces, busy_, {}, [](const v1::BackUpResponse&) { return true; });
    });
    other.join();
    return TwoPieces(sink);
  });
  EXPECT_TRUE(first.ok()) << first;
  EXPECT_TRUE(absl::IsResourceExhausted(second)) << second;
}

}  // namespace
}  // namespace isthmus::rpc
