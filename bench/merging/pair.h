// Two simulated robots of which one may have seen what the other has.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <string>

#include "client/simulation/simulator.h"

namespace isthmus::bench {

struct PairOptions {
  std::string world_a = "museum";
  std::string world_b = {};  // One world for both if empty.
  uint64_t seed = 1;
  double seconds = 60;
  int walkers = 0;
  double tilt_deg = 0;  // The second robot's sensor is mounted askew by so much about x and y.
};

// The drives of robots a and b. Immutable.
class Pair {
 public:
  // InvalidArgument for a world that does not exist.
  static absl::StatusOr<Pair> Make(const PairOptions& options);

  int scan_count() const { return a_->scan_count(); }
  Scan MakeScan(int robot, int index) const {
    return robot == 0 ? a_->MakeScan(0, index) : b_->MakeScan(index_b_, index);
  }
  // T_world_sensor at the END of the scan; means something between robots only if they are in one
  // world.
  Pose Truth(int robot, int index) const {
    return robot == 0 ? a_->Truth(0, index).pose : b_->Truth(index_b_, index).pose;
  }
  int64_t Stamp(int robot, int index) const {
    return robot == 0 ? a_->Truth(0, index).stamp_ns : b_->Truth(index_b_, index).stamp_ns;
  }
  bool SameWorld() const { return same_world_; }
  double overlap_cell_m() const { return a_->world().overlap_cell_m; }

 private:
  std::shared_ptr<const simulation::Simulator> a_, b_;
  int index_b_ = 1;  // Of robot b in its simulator.
  bool same_world_ = true;
};

}  // namespace isthmus::bench
