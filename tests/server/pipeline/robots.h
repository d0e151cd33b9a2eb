// Robots for tests of the pipeline: a few scans of a simulated drive, and stores that fail.
#pragma once

#include <absl/status/status.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "core/codec/payload_builder.h"
#include "lab/simulation/simulator.h"
#include "server/pipeline.h"
#include "storage/forwarding_store.h"
#include "storage/memory_store.h"

namespace isthmus::server {

inline const RobotId kAlice("alice"), kBob("bob");

// Opens a session of a robot with a VLP-16.
inline SessionId Create(Pipeline& pipeline, const RobotId& robot = kAlice) {
  return pipeline.sessions().Create({robot, "vlp16"}).value().record.id;
}

// A drive through the museum of one robot and the scans it would send.
class Drive {
 public:
  explicit Drive(int robots = 1, uint64_t seed = 3) {
    simulation::Options options;
    options.robots = robots;
    options.seed = seed;
    simulator_ = std::move(simulation::Simulator::Create(options).value());
  }

  // Scan `index` (from 0) as the upload of sequence index + 1.
  ScanUpload Upload(int index, int robot = 0) const {
    const Scan scan = simulator_->MakeScan(robot, index);
    return {scan.sequence, scan.end_stamp_ns, codec::MakePayload(scan)};
  }
  // Submits scans [from, to); returns the first error.
  absl::Status Submit(Pipeline& pipeline, const SessionId& session, int from, int to,
                      int robot = 0) const {
    absl::Status status;
    for (int i = from; i < to && status.ok(); ++i) {
      status = pipeline.sessions().SubmitScan(session, Upload(i, robot));
    }
    return status;
  }
  const simulation::Simulator& simulator() const { return *simulator_; }

 private:
  std::unique_ptr<simulation::Simulator> simulator_;
};

// Collects what a session is told. Thread safe; its sinks may outlive it, since a pipeline
// acknowledges what is left as it ends.
class AckLog {
 public:
  AckSink Sink() {
    return [acks = acks_](const ScanAck& ack) {
      std::lock_guard lock(acks->mutex);
      acks->list.push_back(ack);
    };
  }
  std::vector<ScanAck> Take() {
    std::lock_guard lock(acks_->mutex);
    return std::exchange(acks_->list, {});
  }
  // Without those that only say what is durable.
  std::vector<ScanAck> TakeScans() {
    std::vector<ScanAck> acks = Take();
    std::erase_if(acks, [](const ScanAck& ack) { return ack.sequence == 0; });
    return acks;
  }

 private:
  struct Acks {
    std::mutex mutex;
    std::vector<ScanAck> list;  // Guarded by mutex.
  };

  const std::shared_ptr<Acks> acks_ = std::make_shared<Acks>();
};

// Another store that stores no submaps while `full` is set: a disk without space.
class FullDisk : public storage::ForwardingStore {
 public:
  FullDisk(std::unique_ptr<storage::MapStore> store, std::shared_ptr<std::atomic<bool>> full)
      : ForwardingStore(std::move(store)), full_(std::move(full)) {}

  absl::Status Write(const storage::WriteBatch& batch) override {
    if (*full_ && !batch.submaps.empty()) return absl::ResourceExhaustedError("disk full");
    return ForwardingStore::Write(batch);
  }

 private:
  const std::shared_ptr<std::atomic<bool>> full_;
};

// Composition at once, submaps of five scans.
inline PipelineOptions QuickOptions() {
  PipelineOptions options;
  options.composition_interval_s = 0;
  options.submap.cut_scans = 5;
  return options;
}

inline std::unique_ptr<Pipeline> OpenInMemory(const PipelineOptions& options = QuickOptions()) {
  return std::move(Pipeline::Open(options, storage::MakeMemoryStore()).value());
}

// Pairs of which a person said something.
inline int64_t CountVerdicts(Pipeline& pipeline) {
  const std::vector<MatchEdge> matches = pipeline.reader().GetMatchGraph().matches;
  return std::count_if(matches.begin(), matches.end(),
                       [](const MatchEdge& edge) { return edge.manual_decision.has_value(); });
}

}  // namespace isthmus::server
