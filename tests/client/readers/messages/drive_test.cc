// The same drive, read from every kind of recording.
#include <algorithm>

#include "tests/client/readers/messages/drive_formulas.h"

namespace isthmus::readers {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

struct DriveFile {
  const char* name;
  const char* kind;
  bool ros2;
};

class DriveTest : public testing::TestWithParam<DriveFile> {
 protected:
  void SetUp() override {
    auto opened = OpenMessageRecording(DataFile(GetParam().name), EchoFactories());
    ASSERT_TRUE(opened.ok()) << opened.status();
    recording_ = *std::move(opened);
  }

  std::unique_ptr<Recording> recording_;
};

TEST_P(DriveTest, HasItsTopics) {
  EXPECT_EQ(recording_->kind(), GetParam().kind);
  EXPECT_THAT(recording_->notes(), IsEmpty());
  std::vector<std::string> topics;
  for (const ScanTopic& topic : recording_->scan_topics()) {
    topics.push_back(topic.name + " " + topic.type + " " + std::to_string(*topic.messages));
  }
  const std::string ouster = GetParam().ros2 ? "ouster_sensor_msgs" : "ouster_ros";
  EXPECT_THAT(topics, ElementsAre("/a/points sensor_msgs/PointCloud2 3",
                                  "/b/points sensor_msgs/PointCloud2 3",
                                  "/livox/lidar livox_ros_driver2/CustomMsg 2",
                                  "/os/lidar_packets " + ouster + "/PacketMsg 2",
                                  "/velodyne_packets velodyne_msgs/VelodyneScan 1"));
}

TEST_P(DriveTest, GivesTheCloudsAsTheyWere) {
  const ReadAll a = ReadTopic(*recording_, "/a/points");
  const ReadAll b = ReadTopic(*recording_, "/b/points");
  const ReadAll livox = ReadTopic(*recording_, "/livox/lidar");
  for (const ReadAll* all : {&a, &b, &livox}) EXPECT_THAT(all->errors, IsEmpty());
  ASSERT_EQ(a.scans.size(), 3u);
  ASSERT_EQ(b.scans.size(), 3u);
  ASSERT_EQ(livox.scans.size(), 2u);
  for (int k = 0; k < 3; ++k) {
    ExpectScanA(a.scans[k], k);
    ExpectScanB(b.scans[k], k);
  }
  for (int k = 0; k < 2; ++k) ExpectLivox(livox.scans[k], k);
}

TEST_P(DriveTest, SaysWhatItTookForGranted) {
  auto reader = recording_->OpenScans(0, {});
  ASSERT_TRUE(reader.ok());
  EXPECT_EQ((*reader)->size(), 3u);
  EXPECT_EQ((*reader)->sensor(), "");
  ASSERT_TRUE((*reader)->Next().ok());
  EXPECT_EQ((*reader)->sensor(), "vlp16");
  EXPECT_THAT((*reader)->Assumptions(), ElementsAre(HasSubstr("START of scans")));
  auto livox = recording_->OpenScans(2, {});
  EXPECT_EQ((*livox)->sensor(), "livox");
}

TEST_P(DriveTest, ARangeCountsTheWholeRecording) {
  const ReadAll a = ReadTopic(*recording_, "/a/points", {.from = 1, .to = 1});
  ASSERT_EQ(a.scans.size(), 1u);
  ExpectScanA(a.scans[0], 1);
  EXPECT_EQ((*recording_->OpenScans(0, {.from = 1, .to = 7}))->size(), 2u);
  EXPECT_TRUE(absl::IsInvalidArgument(recording_->OpenScans(0, {.from = 3}).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(recording_->OpenScans(9, {}).status()));
  EXPECT_TRUE(absl::IsInvalidArgument(recording_->OpenScans(0, {.rate_hz = 0}).status()));
}

TEST_P(DriveTest, ReadersGoOnBesideEachOther) {
  auto a = *recording_->OpenScans(0, {});
  auto b = *recording_->OpenScans(1, {});
  auto again = *recording_->OpenScans(0, {});
  for (int k = 0; k < 3; ++k) {
    ExpectScanA(**a->Next(), k);
    ExpectScanB(**b->Next(), k);
    ExpectScanA(**again->Next(), k);
  }
  EXPECT_FALSE((*a->Next()).has_value());
  EXPECT_FALSE((*a->Next()).has_value());
  auto interrupted = *recording_->OpenScans(0, {});
  interrupted->Interrupt();
  EXPECT_FALSE((*interrupted->Next()).has_value());
}

TEST_P(DriveTest, PacketsReachTheirDecoders) {
  const ReadAll velodyne = ReadTopic(*recording_, "/velodyne_packets");
  ASSERT_EQ(velodyne.scans.size(), 2u);
  for (int p = 0; p < 2; ++p) {
    const RecordedScan& scan = velodyne.scans[p];
    EXPECT_EQ(scan.name, "scan " + std::to_string(p) + " of /velodyne_packets");
    EXPECT_EQ(scan.end_stamp_ns, kDriveStartNs + 100'000'000 + p * 1'000'000);
    ASSERT_EQ(scan.payload.data.size(), 1206u);
    for (int j = 0; j < 1206; ++j) ASSERT_EQ(scan.payload.data[j], VelodyneByte(p, j)) << j;
  }
  const ReadAll ouster = ReadTopic(*recording_, "/os/lidar_packets");
  ASSERT_EQ(ouster.scans.size(), 2u);
  for (int k = 0; k < 2; ++k) {
    const RecordedScan& scan = ouster.scans[k];
    EXPECT_EQ(scan.end_stamp_ns, kDriveStartNs + 300'000'000 + k * 1'000'000);
    ASSERT_EQ(scan.payload.data.size(), 64u);
    for (int j = 0; j < 64; ++j) ASSERT_EQ(scan.payload.data[j], OusterByte(k, j)) << j;
  }
}

TEST_P(DriveTest, MetadataAreThoseOfTheRecording) {
  auto reader = *recording_->OpenScans(3, {});
  ASSERT_TRUE(reader->Next().ok());
  EXPECT_EQ(reader->sensor(), "{\"beams\": 16}");
  EXPECT_THAT(reader->Assumptions(), ElementsAre("packets are echoed"));
  EXPECT_TRUE(absl::IsNotFound(recording_->OpenScans(3, {.metadata = "/no/such.json"}).status()));
  EXPECT_TRUE(
      absl::IsNotFound(recording_->OpenScans(4, {.calibration = "/no/such.yaml"}).status()));
}

TEST_P(DriveTest, HasFixesAndTransforms) {
  ASSERT_EQ(recording_->gnss_topics().size(), 1u);
  EXPECT_EQ(recording_->gnss_topics()[0].name, "/gps/fix");
  EXPECT_EQ(recording_->gnss_topics()[0].messages, 3u);
  const auto fixes = recording_->ReadFixes(0);
  ASSERT_TRUE(fixes.ok()) << fixes.status();
  ASSERT_EQ(fixes->size(), 2u);  // One had no status.
  for (const int i : {0, 1}) {
    const GnssFix& fix = (*fixes)[i];
    const int k = 2 * i;
    EXPECT_EQ(fix.stamp_ns, kDriveStartNs + 50'000'000 + k * 100'000'000);
    EXPECT_EQ(fix.frame, "gps");
    EXPECT_DOUBLE_EQ(fix.latitude_deg, 48 + 1e-5 * k);
    EXPECT_DOUBLE_EQ(fix.longitude_deg, 11 + 2e-5 * k);
    EXPECT_DOUBLE_EQ(fix.altitude_m, 500 + k);
    EXPECT_DOUBLE_EQ(fix.sigma_east_m, i == 0 ? 0.2 : 0);
    EXPECT_DOUBLE_EQ(fix.sigma_north_m, i == 0 ? 0.3 : 0);
    EXPECT_DOUBLE_EQ(fix.sigma_up_m, i == 0 ? 0.5 : 0);
  }
  const auto edges = recording_->ReadStaticTransforms();
  ASSERT_TRUE(edges.ok()) << edges.status();
  ASSERT_EQ(edges->size(), 2u);
  EXPECT_EQ((*edges)[0].child, "gps");
  EXPECT_EQ((*edges)[1].parent, "base");
  EXPECT_EQ((*edges)[1].child, "lidar_a");
  EXPECT_NEAR((*edges)[1].T_parent_child.Yaw(), 1.5707963267948966, 1e-12);
  EXPECT_EQ((*edges)[1].T_parent_child.translation(), Eigen::Vector3d(1, 2, 3));
}

INSTANTIATE_TEST_SUITE_P(
    All, DriveTest,
    testing::Values(
        DriveFile{"drive_none.bag", "ROS 1 bag", false},
        DriveFile{"drive_bz2.bag", "ROS 1 bag", false},
        DriveFile{"drive_lz4.bag", "ROS 1 bag", false}, DriveFile{"drive_none.mcap", "MCAP", true},
        DriveFile{"drive_lz4.mcap", "MCAP", true}, DriveFile{"drive_zstd.mcap", "MCAP", true},
        DriveFile{"drive_bare.mcap", "MCAP", true}, DriveFile{"drive_loose.mcap", "MCAP", true},
        DriveFile{"drive.db3", "ROS 2 bag (db3)", true},
        DriveFile{"split_bag", "ROS 2 bag (db3)", true},
        DriveFile{"packed_bag", "ROS 2 bag (db3)", true},
        // Nothing beside it says that it is compressed.
        DriveFile{"packed_bag/packed_0.db3", "ROS 2 bag (db3)", true}),
    [](const auto& test) {
      std::string name = test.param.name;
      std::replace_if(
          name.begin(), name.end(), [](char c) { return !std::isalnum(c); }, '_');
      return name;
    });

}  // namespace
}  // namespace isthmus::readers
