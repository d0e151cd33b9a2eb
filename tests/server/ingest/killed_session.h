// A server's worker that is killed and started anew over a store that stays, and the robot that
// sends to it.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/concurrency/executor.h"
#include "core/state_codec.h"
#include "floam/state/unfinished_submap.h"
#include "server/ingest/session_worker.h"

namespace isthmus::ingest::testing {

// The durable part: it survives the worker.
class Store {
 public:
  absl::Status Persist(const FinishedSubmap& finished) {
    if (is_full) return absl::ResourceExhaustedError("the disk is full");
    Kept& kept = segments_[finished.segment];
    if (finished.submap != nullptr) {
      EXPECT_EQ(finished.submap->id.session, SegmentId(kSession, finished.segment));
      EXPECT_EQ(finished.submap->id.index, kept.submaps.size()) << "twice, or one is missing";
      kept.submaps.push_back(finished.submap);
    }
    for (const TrajectoryEntry& entry : finished.trajectory) {
      EXPECT_TRUE(kept.trajectory.emplace(entry.sequence, entry).second) << entry.sequence;
    }
    if (finished.checkpoint) {
      EXPECT_TRUE(finished.checkpoint->state.has_value());
      checkpoint = finished.checkpoint;
      segments_[checkpoint->segment];
      ++checkpoints;
    }
    return absl::OkStatus();
  }

  ResumePoint Resume() const {
    ResumePoint resume;
    resume.checkpoint = checkpoint;
    for (const auto& [number, kept] : segments_) {
      StoredSegment& segment = resume.segments.emplace_back();
      segment.segment = number;
      segment.next_index = static_cast<uint32_t>(kept.submaps.size());
      if (!kept.submaps.empty()) segment.last_sequence = kept.submaps.back()->last_sequence;
      segment.for_each_submap = [&kept](const std::function<void(const Submap&)>& visit) {
        for (const auto& submap : kept.submaps) visit(*submap);
      };
      for (const auto& [sequence, entry] : kept.trajectory) segment.trajectory.push_back(entry);
    }
    return resume;
  }

  // All of it, as bytes.
  std::string Contents() const {
    StateWriter out;
    for (const auto& [number, kept] : segments_) {
      out(number);
      for (const auto& submap : kept.submaps) {
        out(submap->id.index);
        floam::WriteUnfinished(*submap, out);
      }
      for (const auto& [sequence, entry] : kept.trajectory) {
        out(sequence, entry.stamp_ns, entry.T_odom_sensor, entry.submap_index);
      }
    }
    return out.Take();
  }
  const std::vector<std::shared_ptr<const Submap>>& submaps(uint32_t segment = 1) {
    return segments_[segment].submaps;
  }
  const std::map<uint64_t, TrajectoryEntry>& trajectory(uint32_t segment) {
    return segments_[segment].trajectory;
  }
  bool has_segment(uint32_t segment) const { return segments_.contains(segment); }

  std::optional<SessionCheckpoint> checkpoint;
  int checkpoints = 0;
  bool is_full = false;

  inline static const SessionId kSession{"alice-1"};

 private:
  struct Kept {
    std::vector<std::shared_ptr<const Submap>> submaps;
    std::map<uint64_t, TrajectoryEntry> trajectory;
  };
  std::map<uint32_t, Kept> segments_;
};

// A server's worker and the robot that sends to it; the robot keeps what is not durable.
class Session {
 public:
  Session(Store* store, SessionWorker::Options options) : store_(store), options_(options) {
    Start();
  }

  // Killed, and started anew; the robot sends again what it kept.
  void Restart() {
    worker_ = nullptr;
    Start();
    const WorkerStatus status = worker_->Status();
    ASSERT_GE(status.durable_sequence, robot_durable_) << "the robot has let go of these";
    for (uint64_t sequence = status.durable_sequence + 1; sequence <= sent_.size(); ++sequence) {
      const ScanAck ack = Submit(sequence);
      EXPECT_EQ(ack.outcome == ScanOutcome::kDuplicate, sequence <= status.last_sequence);
    }
  }

  ScanAck Send(PointPayload payload, int64_t end_stamp_ns) {
    sent_.push_back({sent_.size() + 1, end_stamp_ns, std::move(payload)});
    return Submit(sent_.size());
  }

  // From now on the robot has all its scans again, as an archive of them would.
  void KeepAll() { robot_durable_ = 0; }
  SessionWorker& worker() { return *worker_; }
  std::vector<std::string> told;  // For the log, of all workers.

 private:
  void Start() {
    SessionRecord record;
    record.id = Store::kSession;
    record.robot = RobotId("alice");
    WorkerHooks hooks;
    hooks.persist = [this](const FinishedSubmap& finished) { return store_->Persist(finished); };
    hooks.T_map_odom = [](uint32_t) { return std::nullopt; };
    hooks.scan_done = [] {};
    hooks.tell = [this](const Event& event) { told.push_back(event.text); };
    worker_ = SessionWorker::Create(record, floam::FindSensorModel("vlp16").value(), options_,
                                    hooks, &executor_, store_->Resume());
    worker_->SetAckSink([this](const ScanAck& ack) {
      if (ack.sequence > 0) last_ack_ = ack;
    });
  }

  ScanAck Submit(uint64_t sequence) {
    last_ack_ = ScanAck();
    const absl::Status status = worker_->Submit(sent_[sequence - 1]);
    EXPECT_TRUE(status.ok()) << status;
    EXPECT_TRUE(executor_.WaitUntilIdle().ok());
    EXPECT_EQ(last_ack_.sequence, sequence);
    EXPECT_GE(last_ack_.durable_sequence, robot_durable_);
    robot_durable_ = last_ack_.durable_sequence;
    return last_ack_;
  }

  Store* const store_;
  const SessionWorker::Options options_;
  Executor executor_{1};
  std::shared_ptr<SessionWorker> worker_;
  std::vector<ScanUpload> sent_;
  uint64_t robot_durable_ = 0;  // As the robot knows.
  ScanAck last_ack_;
};

}  // namespace isthmus::ingest::testing
