#include "lab/bench/merging/driven_robot.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "client/evaluation/trajectory_error.h"
#include "core/codec/payload_builder.h"
#include "core/concurrency/mutex.h"
#include "core/formats/tum.h"
#include "core/io/file_io.h"
#include "lab/bench/merging/temporary_folder.h"
#include "server/pipeline.h"
#include "storage/sqlite/sqlite_store.h"

namespace isthmus::bench {
namespace {

constexpr char kTruth[] = "/truth.tum", kAbout[] = "/drive.json", kStore[] = "/isthmus.db";

// Counts what the odometry says it lost. Acks come from the server's threads.
class LostScans {
 public:
  AckSink Sink() {
    return [this](const ScanAck& ack) {
      MutexLock lock(&mutex_);
      if (ack.tracking == Tracking::kLost) ++count_;
    };
  }
  int count() {
    MutexLock lock(&mutex_);
    return count_;
  }

 private:
  Mutex mutex_;
  int count_ ABSL_GUARDED_BY(mutex_) = 0;
};

absl::Status Stream(const Drive& drive, server::Pipeline& pipeline, LostScans* lost) {
  const auto session = pipeline.sessions().Create({RobotId("robot"), drive.sensor});
  if (!session.ok()) return session.status();
  const SessionId id = session->record.id;
  absl::Status status = pipeline.sessions().SetAckSink(id, lost->Sink());
  uint64_t sequence = 0;
  for (const Shot& shot : drive.shots) {
    if (!status.ok()) return status;
    const Scan scan = MakeScan(drive, shot, ++sequence);
    status = pipeline.sessions().SubmitScan(
        id, {scan.sequence, scan.end_stamp_ns, codec::MakePayload(scan)});
  }
  if (!status.ok()) return status;
  return pipeline.sessions().Finish(id).status();
}

// The store's file is copied first: one that is opened is locked, and migrated if need be.
absl::StatusOr<std::unique_ptr<storage::MapStore>> OpenCopy(const std::string& folder,
                                                            const std::string& copy) {
  const auto bytes = io::ReadFile(folder + kStore);
  if (!bytes.ok()) return bytes.status();
  if (absl::Status status = io::WriteFile(copy + kStore, *bytes); !status.ok()) return status;
  return storage::OpenSqliteStore(copy);
}

absl::Status LoadStored(const storage::MapStore& store, DrivenRobot* robot) {
  const auto sessions = store.ListSessions();
  if (!sessions.ok()) return sessions.status();
  std::vector<SubmapInfo> submaps;  // The submaps of the segment with the most.
  for (const SessionRecord& session : *sessions) {
    auto listed = store.ListSubmaps(session.id);
    if (!listed.ok()) return listed.status();
    if (listed->size() <= submaps.size()) continue;
    robot->session = session;
    robot->session.segment = 1;  // As if there had been no other.
    robot->session.first_segment = {};
    submaps = *std::move(listed);
  }
  if (submaps.empty()) return absl::DataLossError("a drive without submaps");
  for (const SubmapInfo& info : submaps) {
    auto submap = store.GetSubmap(info.id);
    if (!submap.ok()) return submap.status();
    robot->submaps.push_back(*std::move(submap));
  }
  return absl::OkStatus();
}

// Poses of lost scans are missing from the trajectory: scans are found by their stamps.
absl::Status JoinPoses(const storage::MapStore& store, const Trajectory& truth,
                       DrivenRobot* robot) {
  std::map<int64_t, const Pose*> by_stamp;
  for (const StampedPose& pose : truth) by_stamp[pose.stamp_ns] = &pose.pose;
  const auto trajectory = store.GetTrajectory(robot->session.id);
  if (!trajectory.ok()) return trajectory.status();
  for (const TrajectoryEntry& entry : *trajectory) {
    const auto it = by_stamp.find(entry.stamp_ns);
    if (it == by_stamp.end()) return absl::DataLossError("a scan without a true pose");
    robot->poses.push_back(
        {entry.sequence, entry.stamp_ns, entry.submap_index, *it->second, entry.T_odom_sensor});
  }
  if (robot->poses.empty()) return absl::DataLossError("lost from the first scan on");
  return absl::OkStatus();
}

}  // namespace

const ScanPose* DrivenRobot::FindPose(uint64_t sequence) const {
  const auto it = std::lower_bound(
      poses.begin(), poses.end(), sequence,
      [](const ScanPose& pose, uint64_t wanted) { return pose.sequence < wanted; });
  return it == poses.end() || it->sequence != sequence ? nullptr : &*it;
}

double DrivenRobot::OdometryRmse() const {
  Trajectory truth, estimate;
  for (const ScanPose& pose : poses) {
    truth.push_back({pose.stamp_ns, pose.T_world_sensor});
    estimate.push_back({pose.stamp_ns, pose.T_odom_sensor});
  }
  const auto errors = evaluation::CompareTrajectories({{"robot", truth, estimate}});
  return errors.ok() ? errors->all.rmse_m : std::numeric_limits<double>::quiet_NaN();
}

absl::Status DriveThroughServer(const GroundedDrive& grounded,
                                const server::PipelineOptions& options, const std::string& folder) {
  auto store = storage::OpenSqliteStore(folder, {.sync_every_commit = false});
  if (!store.ok()) return store.status();
  server::PipelineOptions alone = options;
  alone.composition_interval_s = 1e6;  // Nobody looks at the map.
  LostScans lost;
  {
    const auto pipeline = server::Pipeline::Open(alone, *std::move(store));
    if (!pipeline.ok()) return pipeline.status();
    absl::Status status = Stream(grounded.drive, **pipeline, &lost);
    if (!status.ok()) return status;
  }
  Trajectory truth;
  for (const Shot& shot : grounded.drive.shots) {
    truth.push_back({shot.end_stamp_ns, grounded.drive.truth_of(shot.turn)});
  }
  absl::Status status = formats::WriteTum(folder + kTruth, truth);
  if (!status.ok()) return status;
  const nlohmann::ordered_json about = {{"ground", grounded.ground},
                                        {"overlap_cell_m", grounded.overlap_cell_m},
                                        {"lost_scans", lost.count()},
                                        {"further_m", grounded.further_m},
                                        {"blocked", grounded.blocked}};
  return io::WriteFile(folder + kAbout, about.dump(2) + "\n");
}

absl::StatusOr<DrivenRobot> LoadDrivenRobot(const std::string& folder) {
  const auto text = io::ReadFile(folder + kAbout);
  if (!text.ok()) return text.status();
  const auto about = nlohmann::json::parse(*text, nullptr, false);
  DrivenRobot robot;
  if (!about.is_object()) return absl::DataLossError(folder + kAbout + " is not JSON");
  robot.ground = about.value("ground", "");
  robot.overlap_cell_m = about.value("overlap_cell_m", 1.0);
  robot.lost_scans = about.value("lost_scans", 0);
  robot.further_m = about.value("further_m", 0.0);
  robot.blocked = about.value("blocked", false);
  const auto truth = formats::ReadTum(folder + kTruth);
  if (!truth.ok()) return truth.status();
  const TemporaryFolder copy;
  const auto store = OpenCopy(folder, copy.path());
  if (!store.ok()) return store.status();
  absl::Status status = LoadStored(**store, &robot);
  if (status.ok()) status = JoinPoses(**store, *truth, &robot);
  if (!status.ok()) {
    return absl::Status(status.code(), absl::StrCat(folder, ": ", status.message()));
  }
  return robot;
}

DrivenRobot PartOf(const DrivenRobot& robot, size_t from, size_t to) {
  DrivenRobot part = robot;
  part.submaps.clear();
  part.poses.clear();
  to = std::min(to, robot.submaps.size());
  for (size_t i = from; i < to; ++i) {
    auto submap = std::make_shared<Submap>(*robot.submaps[i]);
    submap->id.index = static_cast<uint32_t>(i - from);
    part.submaps.push_back(std::move(submap));
  }
  for (ScanPose pose : robot.poses) {
    if (pose.submap < from || pose.submap >= to) continue;
    pose.submap -= static_cast<uint32_t>(from);
    part.poses.push_back(pose);
  }
  return part;
}

void Rename(DrivenRobot* robot, const std::string& name) {
  robot->session.robot = RobotId(name);
  robot->session.id = SessionId(name + "-1");
  for (auto& submap : robot->submaps) {
    auto renamed = std::make_shared<Submap>(*submap);
    renamed->robot = robot->session.robot;
    renamed->id.session = robot->session.id;
    submap = std::move(renamed);
  }
  for (Anchor& anchor : robot->anchors) anchor.submap.session = robot->session.id;
}

}  // namespace isthmus::bench
