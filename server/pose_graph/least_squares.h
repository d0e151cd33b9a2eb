// The least-squares problem of a pose graph under given weights, kept between solutions.
#pragma once

#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "server/pose_graph/gauge.h"
#include "server/pose_graph/optimize.h"

namespace isthmus::pose_graph {

// The weight of each edge and anchor.
struct Weights {
  std::vector<double> edges, anchors;
};

// One thread at a time.
class LeastSquares {
 public:
  // Keeps a reference to `problem`, which must have passed Validate. InvalidArgument when an
  // information matrix is not one.
  static absl::StatusOr<std::unique_ptr<LeastSquares>> Create(const Problem& problem,
                                                              const Gauge& gauge);
  virtual ~LeastSquares() = default;

  struct Effort {
    int max_iterations = 100;
    double tolerance = 1e-11;  // Relative change of the cost at which it is good enough.
    double max_seconds = 0;    // 0: no limit.
    int num_threads = 1;
  };
  struct Outcome {
    int iterations = 0;
    bool converged = false;
  };
  // Goes on from where the last solution ended, with Weights as they are now. Internal when the
  // solver fails; poses are then those before.
  virtual absl::StatusOr<Outcome> Solve(const Effort& effort) = 0;

  virtual Weights& weights() = 0;  // For `problem`'s edges and anchors; 1 at first.
  virtual std::vector<Pose> poses() const = 0;
  virtual void set_poses(const std::vector<Pose>& poses) = 0;  // As many.
};

}  // namespace isthmus::pose_graph
