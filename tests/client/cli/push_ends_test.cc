// What `isthmus push` says where a drive does not come into the map as a whole.
#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/console/push_scans.h"
#include "client/offline/embedded_server.h"
#include "client/readers/started_reader.h"
#include "core/codec/payload_builder.h"
#include "tests/core/codec/payloads.h"

namespace isthmus::cli {
namespace {

using testing::HasSubstr;

constexpr uint64_t kScans = 60, kMeddledAt = 30;

// Scans of a room, in the middle of which something happens.
class MeddledScans final : public readers::ScanReader {
 public:
  explicit MeddledScans(std::function<void()> meddle) : meddle_(std::move(meddle)) {}

  absl::StatusOr<std::optional<readers::RecordedScan>> Next() override {
    if (read_ == kScans) return std::nullopt;
    if (++read_ == kMeddledAt) meddle_();
    readers::RecordedScan scan;
    scan.end_stamp_ns = static_cast<int64_t>(read_) * 100'000'000;
    scan.payload = codec::MakePayload(codec::RoomScan(), true, true);
    return scan;
  }

 private:
  const std::function<void()> meddle_;
  uint64_t read_ = 0;
};

class PushEndsTest : public testing::Test {
 protected:
  void SetUp() override {
    auto server = EmbeddedServer::Start({});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }

  // What it says on stderr, and how it ends.
  std::pair<std::string, absl::Status> Push(std::function<void()> meddle) {
    std::vector<RobotScans> robots(1);
    robots[0].robot = "alice";
    robots[0].sensor = "vlp16";
    robots[0].reader =
        std::make_unique<readers::StartedReader>(std::make_unique<MeddledScans>(std::move(meddle)));
    PushControl control;
    testing::internal::CaptureStderr();
    const absl::Status status =
        PushRobots(server_->client(), std::move(robots), {}, control).status();
    return {testing::internal::GetCapturedStderr(), status};
  }

  std::unique_ptr<EmbeddedServer> server_;
};

TEST_F(PushEndsTest, OfASessionThatWasFinishedMeanwhileItTellsHowMuchThereIs) {
  const auto [said, status] = Push([this] {
    const auto finished = server_->client().FinishSession(SessionId("alice-1"));
    EXPECT_TRUE(finished.ok()) << finished.status();
  });
  EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
  const auto session = server_->client().GetSession(SessionId("alice-1"));
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_LT(session->last_sequence, kScans);
  EXPECT_THAT(said, HasSubstr(absl::StrCat("session alice-1 is finished, with ",
                                           session->last_sequence, " of the ")));
  EXPECT_THAT(said, HasSubstr("isthmus session delete alice-1"));
}

TEST_F(PushEndsTest, OfASessionThatWasDeletedMeanwhileItTellsThatItIsGone) {
  const auto [said, status] = Push([this] {
    const absl::Status deleted = server_->client().DeleteSession(SessionId("alice-1"));
    EXPECT_TRUE(deleted.ok()) << deleted;
  });
  EXPECT_TRUE(absl::IsNotFound(status)) << status;
  EXPECT_THAT(said, HasSubstr("session alice-1 is gone"));
}

}  // namespace
}  // namespace isthmus::cli
