#include "tests/server/ingest/worker_fixture.h"

#include <gtest/gtest.h>

#include <utility>

#include "core/codec/payload_builder.h"

namespace isthmus::ingest::testing {

SessionWorker::Options SmallSubmaps() {
  SessionWorker::Options options;
  options.submap.cut_scans = 20;
  options.checkpoint_scans = 7;
  return options;
}

Rig::Rig(const std::string& sensor, double speed) : motion_(floam::testing::Loop(speed)) {
  SessionRecord record;
  record.id = SessionId("alice-1");
  record.robot = RobotId("alice");
  record.sensor = sensor;
  WorkerHooks hooks;
  hooks.persist = [this](const FinishedSubmap& finished) {
    stored_.push_back(finished);
    return absl::OkStatus();
  };
  hooks.T_map_odom = [](uint32_t) { return std::nullopt; };
  hooks.scan_done = [] {};
  hooks.tell = [this](const Event& event) { on_told(event.text); };
  worker_ = SessionWorker::Create(record, floam::FindSensorModel(sensor).value(), {}, hooks,
                                  &executor_, {});
  worker_->SetAckSink([this](const ScanAck& ack) { acks_.push_back(ack); });
}

Scan Rig::Turn(int index) const {
  return MakeScan(room_, motion_, floam::testing::Sensor(), index);
}

ScanAck Rig::Send(const Scan& scan, int64_t shift_ns) {
  return Send(codec::MakePayload(scan), scan.end_stamp_ns + shift_ns);
}

ScanAck Rig::Send(PointPayload payload, int64_t end_stamp_ns) {
  last_payload_ = std::move(payload);
  last_stamp_ns_ = end_stamp_ns;
  return Submit(++sequence_, end_stamp_ns);
}

ScanAck Rig::SendAgain(uint64_t sequence) { return Submit(sequence, last_stamp_ns_); }

ScanAck Rig::Submit(uint64_t sequence, int64_t end_stamp_ns) {
  const size_t before = acks_.size();
  const absl::Status status = worker_->Submit({sequence, end_stamp_ns, last_payload_});
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_TRUE(executor_.WaitUntilIdle().ok());
  EXPECT_EQ(acks_.size(), before + 1);
  if (acks_.size() != before + 1) return {};
  EXPECT_EQ(acks_.back().sequence, sequence);
  return acks_.back();
}

double Rig::Error(const ScanAck& ack, int index) const {
  if (!ack.T_odom_sensor) return 1e9;
  const floam::testing::Sensor sensor;
  const Pose T_world_odom = EndPose(motion_, sensor, 0);
  const Pose truth = EndPose(motion_, sensor, index);
  return (truth.Inverse() * (T_world_odom * *ack.T_odom_sensor)).translation().norm();
}

}  // namespace isthmus::ingest::testing
