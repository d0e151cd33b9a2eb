#include "floam/relocalise/relocaliser.h"

#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "floam/odometry_options.h"
#include "tests/floam/building.h"

namespace isthmus::floam {
namespace {

using testing::AlongTheAxis;
using testing::MakeScan;
using testing::MapFrom;
using testing::Motion;
using testing::Room;
using testing::Sensor;

constexpr double kPeriodS = 0.1;

// The usual quality of a right match in these buildings.
MatchQuality Usual() {
  MatchResult match;
  match.agreement = 0.95;
  match.features = 1000;
  match.used = 850;
  MatchQuality quality;
  quality.Add(match);
  return quality;
}

// Asks about scan after scan of a drive, until there is an answer.
class Lost {
 public:
  explicit Lost(const Room& seen, const std::vector<Pose>& from) {
    relocaliser_.Remember(MapFrom(seen, from));
  }

  struct Answer {
    int scans = 0;
    Pose T_odom_end;  // At the END of the last scan asked about.
    ScanPose pose;
  };
  std::optional<Answer> Ask(const Room& room, const Motion& motion, int scans) {
    for (int k = 0; k < scans; ++k) {
      ScanFrame frame;
      if (!maker_.Make(MakeScan(room, motion, Sensor(), k), nullptr, &frame).ok()) continue;
      const auto match = relocaliser_.Find(frame, Pose(), usual_, -0.5 * kPeriodS);
      if (match) return Answer{k + 1, match->pose.At(0), match->pose};
    }
    return std::nullopt;
  }
  Relocaliser& relocaliser() { return relocaliser_; }

 private:
  FrameMaker maker_{*FindSensorModel("vlp16"), FeatureOptions()};
  Relocaliser relocaliser_{MatchOptions(), RelocaliserOptions()};
  const MatchQuality usual_ = Usual();
};

Motion At(double x, double y, double yaw) {
  return [=](double) { return Pose::FromXyzRpy(x, y, 0, 0, 0, yaw); };
}

double PoseError(const Pose& a, const Pose& b) {
  return (a.translation() - b.translation()).norm() + RotationAngle(a.Inverse() * b);
}

TEST(Relocaliser, FindsARobotThatWasPutDownAnywhereAtAnyHeading) {
  const Room building = testing::ThreeRooms();
  Lost lost(building, AlongTheAxis(-16, 16));
  for (const double yaw : {0.0, 2.1, -1.3}) {
    for (const double x : {-13.5, -1.0, 11.0}) {
      const auto answer = lost.Ask(building, At(x, -1.3, yaw), 15);
      ASSERT_TRUE(answer.has_value()) << x << " " << yaw;
      EXPECT_LT(PoseError(answer->T_odom_end, At(x, -1.3, yaw)(0)), 0.06) << x << " " << yaw;
      lost.relocaliser().Reset();
    }
  }
}

TEST(Relocaliser, WallsAreLookedThroughFromAWrongPlaceOnly) {
  const Room building = testing::ThreeRooms();
  Lost lost(building, AlongTheAxis(-16, 16));
  FrameMaker maker(*FindSensorModel("vlp16"), FeatureOptions());
  ScanFrame frame;
  ASSERT_TRUE(
      maker.Make(MakeScan(building, At(-13.5, -1.3, 0), Sensor(), 0), nullptr, &frame).ok());
  const WallsSeen here = lost.relocaliser().Walls(frame, At(-13.5, -1.3, 0)(0));
  EXPECT_GT(here.count(), 300);
  EXPECT_LT(here.through_share(), 0.05);
  const WallsSeen elsewhere = lost.relocaliser().Walls(frame, At(-12, 0.5, 1)(0));
  EXPECT_GT(elsewhere.count(), 300);
  EXPECT_GT(elsewhere.through_share(), 0.3);
}

TEST(Relocaliser, FindsARobotThatDrivesAndTurns) {
  const Room building = testing::ThreeRooms();
  Lost lost(building, AlongTheAxis(-16, 16));
  const Motion motion = [](double time_s) {
    return Pose::FromXyzRpy(9, -2, 0, 0, 0, 1.9) *
           Exp((Vector6d() << 0.8 * time_s, 0, 0, 0, 0, 0.5 * time_s).finished());
  };
  const auto answer = lost.Ask(building, motion, 15);
  ASSERT_TRUE(answer.has_value());
  EXPECT_LT(PoseError(answer->T_odom_end, motion(kPeriodS * answer->scans)), 0.08);
  EXPECT_NEAR(answer->pose.twist[0], 0.8, 0.15);
  EXPECT_NEAR(answer->pose.twist[5], 0.5, 0.1);
}

TEST(Relocaliser, GoesByTheLatestMapWhereTheOdometryHasDrifted) {
  const Room building = testing::ThreeRooms();
  Lost lost(building, AlongTheAxis(-16, 16));
  // The second lap, a hundred submaps later, lies elsewhere in odom.
  const Pose drift = Pose::FromXyzRpy(0.7, -0.5, 0.15, 0, 0, 0.03);
  Submap later = MapFrom(building, AlongTheAxis(-16, 16), 100);
  later.T_odom_submap = drift * later.T_odom_submap;
  lost.relocaliser().Remember(later);
  for (const double x : {-12.0, 1.5, 11.0}) {
    const auto answer = lost.Ask(building, At(x, 0.8, 2.2), 15);
    ASSERT_TRUE(answer.has_value()) << x;
    EXPECT_LT(PoseError(answer->T_odom_end, drift * At(x, 0.8, 2.2)(0)), 0.08) << x;
    lost.relocaliser().Reset();
  }
}

TEST(Relocaliser, FindsARobotWhoseSensorIsMountedAtATilt) {
  // Pitched down by 12 degrees; odom, where the sensor was at first, leans as it does.
  const Pose T_base_sensor = Pose::FromXyzRpy(0, 0, 0, 0.03, 0.21, 0);
  const Room building = testing::ThreeRooms();
  std::vector<Pose> stops;
  for (const Pose& base : AlongTheAxis(-16, 16)) stops.push_back(base * T_base_sensor);
  Submap submap = MapFrom(building, stops);
  const Pose T_odom_world = stops.front().Inverse();
  submap.T_odom_submap = T_odom_world * submap.T_odom_submap;
  Relocaliser relocaliser{MatchOptions(), RelocaliserOptions(), T_base_sensor.rotation()};
  relocaliser.Remember(submap);
  const Pose T_world_sensor = Pose::FromXyzRpy(11, -1, 0, 0, 0, 2.3) * T_base_sensor;
  FrameMaker maker(*FindSensorModel("vlp16"), FeatureOptions());
  std::optional<MatchResult> match;
  for (int k = 0; k < 15 && !match; ++k) {
    ScanFrame frame;
    ASSERT_TRUE(
        maker.Make(testing::StandingScan(building, T_world_sensor, k), nullptr, &frame).ok());
    match = relocaliser.Find(frame, T_odom_world * stops.back(), Usual(), 0);
  }
  ASSERT_TRUE(match.has_value());
  EXPECT_LT(PoseError(match->pose.T_odom_sensor, T_odom_world * T_world_sensor), 0.06);
  // Points around it come in odom, too.
  for (const Point& p : relocaliser.PointsAround(match->pose.T_odom_sensor.translation(), 3)) {
    const Eigen::Vector3d world = T_odom_world.Inverse() * p.Position().cast<double>();
    EXPECT_LT(std::abs(world.z() - 0.8), 2.1);  // Between floor and ceiling.
  }
}

TEST(Relocaliser, IsNotSureBeforeSeveralScansAgree) {
  const Room building = testing::ThreeRooms();
  Lost lost(building, AlongTheAxis(-16, 16));
  const RelocaliserOptions options;
  const auto answer = lost.Ask(building, At(3, 0, 1), 30);
  ASSERT_TRUE(answer.has_value());
  EXPECT_GE(answer->scans, options.patience + options.confirmations - 1);
}

TEST(Relocaliser, DoesNotChooseBetweenTwins) {
  const Room twins = testing::SymmetricRooms();
  Lost lost(twins, AlongTheAxis(-16, 16));
  EXPECT_FALSE(lost.Ask(twins, At(-12, 0.5, 0.7), 40).has_value());
  lost.relocaliser().Reset();
  EXPECT_FALSE(lost.Ask(twins, At(10, -1, 2), 40).has_value());
}

TEST(Relocaliser, StaysLostWhereItHasNeverBeen) {
  Lost lost(testing::ThreeRooms(), AlongTheAxis(-16, 16));
  const Room other = testing::OtherBuilding();
  for (const double x : {-6.0, 0.0, 8.0}) {
    EXPECT_FALSE(lost.Ask(other, At(x, 0.5, 0.4), 30).has_value()) << x;
    lost.relocaliser().Reset();
  }
}

TEST(Relocaliser, StaysLostWithoutAMap) {
  Relocaliser relocaliser{MatchOptions(), RelocaliserOptions()};
  FrameMaker maker(*FindSensorModel("vlp16"), FeatureOptions());
  for (int k = 0; k < 20; ++k) {
    ScanFrame frame;
    ASSERT_TRUE(
        maker.Make(MakeScan(testing::ThreeRooms(), At(0, 0, 0), Sensor(), k), nullptr, &frame)
            .ok());
    EXPECT_FALSE(relocaliser.Find(frame, Pose(), Usual(), 0).has_value());
  }
}

TEST(Relocaliser, DoesNotFollowARobotThatIsMovedByHandMeanwhile) {
  const Room building = testing::ThreeRooms();
  Lost lost(building, AlongTheAxis(-16, 16));
  // Put elsewhere every third scan: no place holds for long enough.
  const Motion motion = [](double time_s) {
    const double place = std::floor(time_s / (3 * kPeriodS) + 1e-6);
    return Pose::FromXyzRpy(-14 + 1.7 * place, 0.5, 0, 0, 0, 0.9 * place);
  };
  EXPECT_FALSE(lost.Ask(building, motion, 45).has_value());
}

TEST(Relocaliser, GivesThePointsAroundAPlace) {
  const Room building = testing::ThreeRooms();
  Relocaliser relocaliser{MatchOptions(), RelocaliserOptions()};
  relocaliser.Remember(MapFrom(building, AlongTheAxis(-16, 16)));
  const Cloud around = relocaliser.PointsAround({12, 0, 0}, 5);
  EXPECT_GT(around.size(), 1000u);
  for (const Point& p : around) {
    EXPECT_LT(std::abs(p.x - 12), 5 + MapMemory::kTileM);
    const float to_wall = std::min(18 - std::abs(p.x), 6 - std::abs(p.y));
    EXPECT_GT(to_wall, -0.1F);
  }
}

}  // namespace
}  // namespace isthmus::floam
