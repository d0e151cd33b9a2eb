// A session worker among nothing but a room: scans in, acks and submaps out, one at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/concurrency/executor.h"
#include "core/point_payload.h"
#include "core/scan_upload.h"
#include "server/ingest/session_worker.h"
#include "tests/floam/room.h"

namespace isthmus::ingest::testing {

// A scan as a robot sends it.
struct SentScan {
  PointPayload payload;
  int64_t end_stamp_ns = 0;
};

// Submaps of 20 scans, and checkpoints that mostly have an unfinished one.
SessionWorker::Options SmallSubmaps();

// Drives a loop through the furnished room; scans end 0.1 s apart. Not thread safe.
class Rig {
 public:
  explicit Rig(const std::string& sensor = "vlp16", double speed = 1.0);

  // The payload of turn `index` of the drive.
  Scan Turn(int index) const;
  // Sends it under the next sequence, its stamp changed by `shift_ns`; the ack.
  ScanAck Send(const Scan& scan, int64_t shift_ns = 0);
  ScanAck Send(PointPayload payload, int64_t end_stamp_ns);
  ScanAck SendAgain(uint64_t sequence);  // The last payload.

  // The error of an ack's pose at the END of turn `index`, metres.
  double Error(const ScanAck& ack, int index) const;

  SessionWorker& worker() { return *worker_; }
  const std::vector<FinishedSubmap>& stored() const { return stored_; }
  // Called with what the worker tells.
  std::function<void(const std::string&)> on_told = [](const std::string&) {};
  static constexpr int64_t kPeriod_ns = 100'000'000;

 private:
  ScanAck Submit(uint64_t sequence, int64_t end_stamp_ns);

  const floam::testing::Room room_ = floam::testing::FurnishedRoom();
  const floam::testing::Motion motion_;
  Executor executor_{1};
  std::shared_ptr<SessionWorker> worker_;
  std::vector<FinishedSubmap> stored_;
  std::vector<ScanAck> acks_;
  uint64_t sequence_ = 0;
  PointPayload last_payload_;
  int64_t last_stamp_ns_ = 0;
};

}  // namespace isthmus::ingest::testing
