// A robot that is picked up, its view blocked, and put down elsewhere in the building.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "core/codec/payload_builder.h"
#include "core/concurrency/executor.h"
#include "server/ingest/session_worker.h"
#include "tests/floam/building.h"

namespace isthmus::ingest {
namespace {

using floam::testing::EndPose;
using floam::testing::MakeScan;
using floam::testing::Motion;
using floam::testing::Room;

constexpr int kDriveScans = 210;
const Pose kPutDown = Pose::FromXyzRpy(-11.5, -1.4, 0, 0, 0, 2.2);

// Through all rooms along the x axis, from rest, at up to 1.5 m/s.
Pose BeforeLift(double time_s) {
  const double moving = std::clamp(time_s - 0.5, 0.0, 1.0);
  const double along = 0.75 * moving * moving + 1.5 * std::max(0.0, time_s - 1.5);
  return Pose::FromXyzRpy(-15 + along, 0.3 * std::sin(along / 3), 0, 0, 0,
                          0.1 * std::cos(along / 3) - 0.1);
}

// From where it was put down, at rest for two seconds and then on at 0.6 m/s.
Pose AfterPutDown(double time_s) {
  const double moving = std::max(0.0, time_s - 2);
  const double along = moving < 1 ? 0.3 * moving * moving : 0.6 * moving - 0.3;
  return kPutDown * Pose(Eigen::Vector3d(along, 0, 0));
}

class MovedRobot {
 public:
  MovedRobot() {
    SessionRecord record;
    record.id = SessionId("alice-1");
    record.robot = RobotId("alice");
    record.sensor = "vlp16";
    WorkerHooks hooks;
    hooks.persist = [this](const FinishedSubmap& finished) {
      stored.push_back(finished);
      return absl::OkStatus();
    };
    hooks.T_map_odom = [](uint32_t) { return std::nullopt; };
    hooks.scan_done = [] {};
    worker_ = SessionWorker::Create(record, floam::FindSensorModel("vlp16").value(), {}, hooks,
                                    &executor_, {});
    worker_->SetAckSink([this](const ScanAck& ack) { acks_.push_back(ack); });
  }

  ScanAck Send(const std::vector<ScanPoint>& points) {
    ++sequence_;
    const int64_t end_ns = 1'000'000'000 + 100'000'000 * static_cast<int64_t>(sequence_);
    EXPECT_TRUE(worker_->Submit({sequence_, end_ns, codec::MakePayload(points, true, true)}).ok());
    EXPECT_TRUE(executor_.WaitUntilIdle().ok());
    return acks_.back();
  }

  std::vector<FinishedSubmap> stored;

 private:
  Executor executor_{1};
  std::shared_ptr<SessionWorker> worker_;
  std::vector<ScanAck> acks_;
  uint64_t sequence_ = 0;
};

TEST(KidnappedRobot, IsLostAndThenFoundInTheSameOdomFrame) {
  const Room building = floam::testing::ThreeRooms();
  const floam::testing::Sensor sensor;
  const Pose T_odom_world = EndPose(BeforeLift, sensor, 0).Inverse();
  const auto error = [&](const ScanAck& ack, const Motion& motion, int index) {
    const Pose off =
        (T_odom_world * EndPose(motion, sensor, index)).Inverse() * ack.T_odom_sensor.value();
    return off.translation().norm() + RotationAngle(off);
  };
  MovedRobot session;
  for (int k = 0; k < kDriveScans; ++k) {
    const ScanAck ack = session.Send(MakeScan(building, BeforeLift, sensor, k).points);
    ASSERT_EQ(ack.tracking, Tracking::kOk) << k;
    ASSERT_LT(error(ack, BeforeLift, k), 0.15) << k;
  }
  const std::vector<ScanPoint> blank(16 * 1200);
  for (int k = 0; k < 10; ++k) EXPECT_NE(session.Send(blank).tracking, Tracking::kOk);

  int lost = 0;
  for (int k = 0; k < 50; ++k) {
    const ScanAck ack = session.Send(MakeScan(building, AfterPutDown, sensor, k).points);
    ASSERT_EQ(ack.outcome, ScanOutcome::kProcessed);
    if (ack.tracking == Tracking::kLost) {
      ++lost;
      EXPECT_GT(ack.covariance->diagonal().maxCoeff(), 1.0);  // And says that it does not know.
      EXPECT_EQ(lost, k + 1);                                 // Once found it is not lost again.
      continue;
    }
    EXPECT_EQ(ack.tracking, Tracking::kOk) << k;
    EXPECT_LT(error(ack, AfterPutDown, k), 0.15) << k;
  }
  EXPECT_GE(lost, 2);  // Never believed at first sight.
  EXPECT_LE(lost, 20);

  // No submap reaches across the carrying.
  for (const FinishedSubmap& finished : session.stored) {
    const Submap& submap = *finished.submap;
    EXPECT_TRUE(submap.last_sequence <= kDriveScans || submap.first_sequence > kDriveScans);
  }
}

}  // namespace
}  // namespace isthmus::ingest
