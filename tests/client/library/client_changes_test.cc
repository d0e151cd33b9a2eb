// Changes of the map through the client: the real RPC layer over a real socket, behind it a
// pipeline that answers what the test says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <limits>

#include "tests/client/library/client_fixture.h"
#include "tests/client/library/poses.h"

namespace isthmus::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

using ClientChangesTest = ClientTest;

ChangedVolume Cabinet(bool came) {
  ChangedVolume volume;
  volume.came = came;
  volume.T_map_box = kPose;
  volume.size = {1.8, 0.5, 2};
  volume.points = 321;
  volume.probability = 0.97;
  volume.seen_first_ns = 10;
  volume.seen_last_ns = 20;
  volume.missing_ns = 30;
  volume.seen_by = {RobotId("alice"), RobotId("carol")};
  volume.missed_by = {RobotId("bob")};
  volume.places = {{1, 2, 3}, {4, 5, 6}};
  return volume;
}

TEST_F(ClientChangesTest, VolumesAreReadInFull) {
  constexpr size_t kVolumes = 20000;  // More than one response holds.
  ChangeList list{.revision = 9, .submaps_before = 4, .submaps_after = 5, .left_out = 6};
  for (size_t i = 0; i < kVolumes; ++i) list.volumes.push_back(Cabinet(i % 2 == 0));
  pipeline_.changes = list;
  ChangeQuery query{.since_ns = 77, .component = 3, .smallest_m = 0.5, .max_volumes = 20};
  query.sphere = RegionQuery::Sphere{{1, 2, 3}, 4};
  query.wants_points = true;
  const auto read = client_->FindChanges(query);
  ASSERT_TRUE(read.ok()) << read.status();

  EXPECT_EQ(pipeline_.asked_changes.since_ns, 77);
  EXPECT_FALSE(pipeline_.asked_changes.since_revision);
  EXPECT_EQ(pipeline_.asked_changes.component, 3u);
  EXPECT_EQ(pipeline_.asked_changes.smallest_m, 0.5);
  EXPECT_EQ(pipeline_.asked_changes.max_volumes, 20u);
  ASSERT_TRUE(pipeline_.asked_changes.sphere);
  EXPECT_EQ(pipeline_.asked_changes.sphere->radius_m, 4);
  EXPECT_TRUE(pipeline_.asked_changes.wants_points);

  EXPECT_EQ(read->revision, 9);
  EXPECT_EQ(read->submaps_before, 4u);
  EXPECT_EQ(read->submaps_after, 5u);
  EXPECT_EQ(read->left_out, 6u);
  ASSERT_EQ(read->volumes.size(), kVolumes);
  EXPECT_TRUE(read->volumes[0].came);
  const ChangedVolume& volume = read->volumes[kVolumes - 1];
  EXPECT_FALSE(volume.came);
  ExpectEqual(volume.T_map_box, kPose);
  EXPECT_EQ(volume.size, Eigen::Vector3d(1.8, 0.5, 2));
  EXPECT_EQ(volume.points, 321u);
  EXPECT_EQ(volume.probability, 0.97);
  EXPECT_EQ(volume.seen_first_ns, 10);
  EXPECT_EQ(volume.seen_last_ns, 20);
  EXPECT_EQ(volume.missing_ns, 30);
  EXPECT_THAT(volume.seen_by, ElementsAre(RobotId("alice"), RobotId("carol")));
  EXPECT_THAT(volume.missed_by, ElementsAre(RobotId("bob")));
  EXPECT_THAT(volume.places, ElementsAre(Eigen::Vector3f(1, 2, 3), Eigen::Vector3f(4, 5, 6)));
}

TEST_F(ClientChangesTest, WhereNothingChangedTheRevisionIsNamed) {
  pipeline_.changes = ChangeList{.revision = 12, .submaps_before = 1, .submaps_after = 1};
  const auto read = client_->FindChanges({.since_revision = 5});
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->revision, 12);
  EXPECT_TRUE(read->volumes.empty());
  EXPECT_EQ(pipeline_.asked_changes.since_revision, 5);
}

TEST_F(ClientChangesTest, QuestionsThatMakeNoSense) {
  const auto refused = [&](const ChangeQuery& query) {
    const absl::Status status = client_->FindChanges(query).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
    return std::string(status.message());
  };
  EXPECT_THAT(refused({}), HasSubstr("since when"));
  EXPECT_THAT(refused({.since_revision = -1}), HasSubstr("counted from 0"));
  EXPECT_THAT(refused({.since_ns = 1, .smallest_m = -1}), HasSubstr("smallest_m"));
  EXPECT_THAT(refused({.since_ns = 1, .smallest_m = std::numeric_limits<double>::quiet_NaN()}),
              HasSubstr("smallest_m"));
  EXPECT_THAT(refused({.since_ns = 1, .sphere = RegionQuery::Sphere{{0, 0, 0}, -1}}),
              HasSubstr("radius"));
}

TEST_F(ClientChangesTest, ErrorsAreTheServers) {
  for (const absl::Status& status :
       {absl::NotFoundError("no such component"), absl::FailedPreconditionError("nothing before"),
        absl::OutOfRangeError("no longer kept")}) {
    pipeline_.changes = status;
    EXPECT_EQ(client_->FindChanges({.since_revision = 1}).status(), status);
  }
}

// A client whose time is up holds no thread of the server.
TEST_F(ClientChangesTest, EndsWithItsCaller) {
  pipeline_.changes_wait = true;
  ClientOptions options{.address = server_->address()};
  options.transfer_timeout_s = 0.2;
  options.backoff.max_attempts = 1;
  const auto hasty = Client::Connect(options);
  ASSERT_TRUE(hasty.ok()) << hasty.status();
  EXPECT_EQ((*hasty)->FindChanges({.since_revision = 1}).status().code(),
            absl::StatusCode::kDeadlineExceeded);
  server_->Shutdown(std::chrono::seconds(30));  // Waits for calls under way.
}

}  // namespace
}  // namespace isthmus::client
