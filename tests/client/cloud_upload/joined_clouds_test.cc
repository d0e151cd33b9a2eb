// Two LiDARs on one robot.
#include "client/cloud_upload/joined_clouds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "client/cloud_upload/columns.h"
#include "core/codec/payload_builder.h"

namespace isthmus::cloud_upload {
namespace {

using readers::RecordedScan;

constexpr int64_t kJoinMs = 1'000'000;

RecordedScan CloudAt(int64_t stamp_ns, const Cloud& cloud) {
  return {stamp_ns, codec::MakePayload(cloud), "cloud at " + std::to_string(stamp_ns / kJoinMs)};
}

class ListReader : public readers::ScanReader {
 public:
  explicit ListReader(std::vector<absl::StatusOr<std::optional<RecordedScan>>> scans)
      : scans_(std::move(scans)) {}
  absl::StatusOr<std::optional<RecordedScan>> Next() override {
    if (at_ == scans_.size()) return std::nullopt;
    return scans_[at_++];
  }
  std::optional<uint64_t> size() const override { return scans_.size(); }
  std::string sensor() const override { return "front"; }

 private:
  std::vector<absl::StatusOr<std::optional<RecordedScan>>> scans_;
  size_t at_ = 0;
};

// 1 m/s forward.
std::optional<Pose> Forward(int64_t to_ns, int64_t from_ns) {
  return Pose::FromXyzRpy(1e-9 * static_cast<double>(from_ns - to_ns), 0, 0, 0, 0, 0);
}

// A LiDAR 1 m behind the leading one that looks back.
Pose Rear() { return Pose::FromXyzRpy(-1, 0, 0, 0, 0, std::numbers::pi); }

std::vector<Eigen::Vector3d> Points(const RecordedScan& scan) {
  const auto columns = ReadColumns(scan.payload);
  EXPECT_TRUE(columns.ok()) << columns.status();
  std::vector<Eigen::Vector3d> points;
  for (size_t i = 0; i < (*columns)[0].size(); ++i) {
    points.emplace_back((*columns)[0][i], (*columns)[1][i], (*columns)[2][i]);
  }
  return points;
}

JoinedClouds Join(std::vector<absl::StatusOr<std::optional<RecordedScan>>> front,
                  std::vector<absl::StatusOr<std::optional<RecordedScan>>> rear,
                  JoinedClouds::Motion motion = Forward) {
  std::vector<MountedClouds> others;
  others.push_back({std::make_unique<ListReader>(std::move(rear)), Rear()});
  return JoinedClouds(std::make_unique<ListReader>(std::move(front)), std::move(others), motion);
}

TEST(JoinedClouds, ArePutWhereTheLeadingOneIs) {
  // The rear one's turn ended 50 ms before: 0.05 m further back.
  JoinedClouds joined = Join({CloudAt(1000 * kJoinMs, {{2, 0, 0, 7}})},
                             {CloudAt(950 * kJoinMs, {{3, 0, 1, 9}, {0, 0, 0, 0}})});
  const auto scan = joined.Next();
  ASSERT_TRUE(scan.ok() && scan->has_value());
  EXPECT_EQ((*scan)->end_stamp_ns, 1000 * kJoinMs);
  const auto points = Points(**scan);
  ASSERT_EQ(points.size(), 2u) << "a ray that never came back is no point";
  EXPECT_LT((points[0] - Eigen::Vector3d(2, 0, 0)).norm(), 1e-6);
  EXPECT_LT((points[1] - Eigen::Vector3d(-4.05, 0, 1)).norm(), 1e-6) << points[1];
  EXPECT_FALSE(joined.Next()->has_value());
}

TEST(JoinedClouds, EachIsTheNearestAndUsedOnce) {
  JoinedClouds joined =
      Join({CloudAt(100 * kJoinMs, {{1, 0, 0, 0}}), CloudAt(200 * kJoinMs, {{1, 0, 0, 0}}),
            CloudAt(210 * kJoinMs, {{1, 0, 0, 0}}), CloudAt(900 * kJoinMs, {{1, 0, 0, 0}})},
           {CloudAt(110 * kJoinMs, {{5, 0, 0, 0}}), CloudAt(190 * kJoinMs, {{6, 0, 0, 0}}),
            CloudAt(500 * kJoinMs, {{7, 0, 0, 0}})});
  std::vector<size_t> sizes;
  while (true) {
    const auto scan = joined.Next();
    if (!scan->has_value()) break;
    sizes.push_back(Points(**scan).size());
  }
  EXPECT_THAT(sizes, testing::ElementsAre(2, 2, 1, 1));
}

TEST(JoinedClouds, WhatTheOtherCannotReadIsSaidAndTheRestGoesOn) {
  JoinedClouds joined =
      Join({CloudAt(100 * kJoinMs, {{1, 0, 0, 0}}), CloudAt(200 * kJoinMs, {{1, 0, 0, 0}})},
           {absl::DataLossError("torn"), CloudAt(200 * kJoinMs, {{5, 0, 0, 0}})});
  EXPECT_EQ(Points(**joined.Next()).size(), 1u);
  EXPECT_TRUE(absl::IsDataLoss(joined.Next().status()));
  EXPECT_EQ(Points(**joined.Next()).size(), 2u);
  EXPECT_FALSE(joined.Next()->has_value());
}

TEST(JoinedClouds, WithoutAPoseTheOthersAreLeftOut) {
  const auto unknown = [](int64_t to_ns, int64_t from_ns) -> std::optional<Pose> {
    return to_ns == from_ns ? std::optional<Pose>(Pose()) : std::nullopt;
  };
  JoinedClouds joined = Join({CloudAt(100 * kJoinMs, {{1, 0, 0, 0}})},
                             {CloudAt(110 * kJoinMs, {{5, 0, 0, 0}})}, unknown);
  EXPECT_EQ(Points(**joined.Next()).size(), 1u);
  EXPECT_TRUE(absl::IsNotFound(joined.Next().status())) << "and it is said";
}

}  // namespace
}  // namespace isthmus::cloud_upload
