// The stages of the server's work, and an observer that is told how long each took.
#pragma once

#include <array>
#include <chrono>

#include "core/ids.h"
#include "core/scan_upload.h"

namespace isthmus {

enum class Stage {
  kDecode,       // A scan's points.
  kOdometry,     // A scan's pose.
  kAcknowledge,  // From a scan's arrival until its acknowledgement was handed to its stream.
  kDurable,      // From a scan's arrival until it survives a crash of the server.
  kStore,        // A submap, with the raw scans that were to be kept, on the disk.
  kMatch,        // A pair of sessions, whatever came of it.
  kLoopSearch,   // A new submap, among the older ones of its session.
  kPlacement,    // All that was new, placed.
  kComposition,  // The merged map.
};

inline constexpr std::array kAllStages = {
    Stage::kDecode, Stage::kOdometry,   Stage::kAcknowledge, Stage::kDurable,    Stage::kStore,
    Stage::kMatch,  Stage::kLoopSearch, Stage::kPlacement,   Stage::kComposition};

// Told from any thread, also those that robots wait for: returns at once, and throws nothing.
class StageObserver {
 public:
  virtual ~StageObserver() = default;
  // Wall time.
  virtual void NoteStage(Stage stage, double seconds) noexcept = 0;
  // A scan was acknowledged.
  virtual void NoteScan(const RobotId& robot, ScanOutcome outcome) noexcept = 0;
};

// Tells the observer of the time until it is destroyed; without one it does nothing.
class StageTimer {
 public:
  StageTimer(StageObserver* observer, Stage stage) : observer_(observer), stage_(stage) {
    if (observer_ != nullptr) start_ = std::chrono::steady_clock::now();
  }
  ~StageTimer() {
    if (observer_ == nullptr) return;
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start_;
    observer_->NoteStage(stage_, passed.count());
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  StageObserver* const observer_;
  const Stage stage_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace isthmus
