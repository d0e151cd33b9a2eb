#include "server/pose_graph/gnc.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>

#include "server/pose_graph/drift_gate.h"
#include "server/pose_graph/limits.h"
#include "server/pose_graph/own_scale.h"

namespace isthmus::pose_graph {
namespace {

class Gnc {
 public:
  Gnc(const Problem& problem, const Options& options, LeastSquares* least_squares)
      : problem_(problem), options_(options), least_squares_(*least_squares) {
    for (size_t i = 0; i < problem.edges.size(); ++i) {
      if (problem.edges[i].may_be_wrong) edges_.push_back(i);
    }
    for (size_t i = 0; i < problem.anchors.size(); ++i) {
      if (problem.anchors[i].may_be_wrong) anchors_.push_back(i);
    }
  }

  absl::Status Run() {
    if (!options_.judge || edges_.size() + anchors_.size() == 0) {
      return Solve(options_.max_iterations);
    }
    absl::Status status = options_.go_on ? GoOn() : absl::OkStatus();
    if (!status.ok() || done_) return status;
    status = BeginSolution();
    if (!status.ok() || done_) return status;
    status = Graduate();
    // Near the truncation the last graduated solution may have left some on the wrong side.
    for (int review = 0; status.ok() && review < kMaxReviews; ++review) {
      const bool changed = Truncate();
      if (review > 0 && !changed) return status;
      status = Solve(options_.max_iterations);
      Measure();
    }
    if (Truncate()) outcome.converged = false;
    return status;
  }

  GncOutcome outcome;

 private:
  absl::Status Solve(int max_iterations, double tolerance = kFineCostChange) {
    double seconds = 0;
    if (options_.max_seconds > 0) {
      const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start_;
      seconds = options_.max_seconds - spent.count();
      outcome.converged = false;
      if (seconds <= 0) return absl::OkStatus();
    }
    const auto solved =
        least_squares_.Solve({max_iterations, tolerance, seconds, options_.num_threads});
    if (!solved.ok()) return solved.status();
    outcome.iterations += solved->iterations;
    outcome.converged = solved->converged;
    return absl::OkStatus();
  }

  // Takes chi2 of all in doubt.
  void Measure() {
    Problem now{least_squares_.poses(), {}, {}, {}};
    chi2_.clear();
    for (const size_t i : edges_) chi2_.push_back(Chi2(now, problem_.edges[i]));
    for (const size_t i : anchors_) chi2_.push_back(Chi2(now, problem_.anchors[i]));
  }

  double& Weight(size_t k) {
    Weights& weights = least_squares_.weights();
    return k < edges_.size() ? weights.edges[edges_[k]]
                             : weights.anchors[anchors_[k - edges_.size()]];
  }

  // Sets the weight of each by `weight_of(chi2)`; tells if all are 0 or 1, and if any changed.
  template <typename WeightOf>
  void SetWeights(const WeightOf& weight_of, bool* decided, bool* changed) {
    *decided = true;
    *changed = false;
    for (size_t k = 0; k < chi2_.size(); ++k) {
      const double weight = weight_of(chi2_[k]);
      double& current = Weight(k);
      if (weight > 0 && weight < 1) *decided = false;
      if (weight != current) *changed = true;
      current = weight;
    }
  }

  double Truncated(double chi2) const { return chi2 <= options_.doubt_chi2 ? 1 : 0; }

  bool Truncate() {
    bool decided = false, changed = false;
    SetWeights([this](double chi2) { return Truncated(chi2); }, &decided, &changed);
    return changed;
  }

  // Tries the weights that are given.
  absl::Status GoOn() {
    const std::vector<Pose> given = least_squares_.poses();
    for (const size_t i : edges_) {
      least_squares_.weights().edges[i] = problem_.edges[i].weight < 0.5 ? 0 : 1;
    }
    for (const size_t i : anchors_) {
      least_squares_.weights().anchors[i] = problem_.anchors[i].weight < 0.5 ? 0 : 1;
    }
    const absl::Status status = Solve(options_.max_iterations);
    if (!status.ok()) return status;
    Measure();
    done_ = true;
    for (size_t k = 0; k < chi2_.size(); ++k) {
      if (Weight(k) != Truncated(chi2_[k])) done_ = false;
    }
    if (done_) return status;
    for (size_t k = 0; k < chi2_.size(); ++k) Weight(k) = 1;
    least_squares_.set_poses(given);
    return status;
  }

  // Leaves the poses where more of those in doubt agree with them: where all of them are believed
  // (right when all are), or where they are given (a few false ones ruin the former).
  absl::Status BeginSolution() {
    const std::vector<Pose> given = least_squares_.poses();
    const std::vector<double> with_drift = ChiSquareWithDrift(problem_);
    const double gate = Gate(with_drift);
    for (const size_t i : edges_) {
      if (!(with_drift[i] <= gate)) least_squares_.weights().edges[i] = 0;
    }
    Measure();
    const double given_cost = RobustCost();
    absl::Status status =
        Solve(std::min(kTrialIterations, options_.max_iterations), kRoughCostChange);
    if (!status.ok()) return status;
    Measure();
    if (*std::max_element(chi2_.begin(), chi2_.end()) <= options_.doubt_chi2) {
      // None was gated either: it would be beyond.
      done_ = true;
      return Solve(options_.max_iterations);
    }
    if (given_cost <= RobustCost()) {
      least_squares_.set_poses(given);
      Measure();
    }
    return status;
  }

  // Edges that contradict sure edges by more than their drift explains are not tried at first.
  // Right edges show it where sure edges stray by more than they admit.
  double Gate(const std::vector<double>& with_drift) const {
    std::vector<double> of_edges;
    for (const size_t i : edges_) of_edges.push_back(with_drift[i]);
    return kGateMargin * options_.doubt_chi2 * std::max(1.0, VarianceScale(std::move(of_edges)));
  }

  // The disagreement of the doubtful edges: by orders of magnitude, so that few which are far off
  // say no more than many which are near.
  double RobustCost() const {
    double cost = 0;
    for (const double chi2 : chi2_) cost += std::log1p(chi2 / options_.doubt_chi2);
    return cost;
  }

  absl::Status Graduate() {
    const double limit = options_.doubt_chi2;
    // Remark 5: convex at the start, for all that is tried. Edges farther off than any drift would
    // only take time.
    double largest = limit;
    for (size_t k = 0; k < chi2_.size(); ++k) {
      if (Weight(k) > 0) largest = std::max(largest, chi2_[k]);
    }
    double mu = std::max(kLeastMu, limit / (2 * largest - limit));
    // Steps enough for any chi2: mu grows 2^60-fold.
    for (int step = 0; step < 60; ++step, mu *= kMuGrowth) {
      bool decided = false, changed = false;
      SetWeights([&](double chi2) { return GncWeight(chi2, limit, mu); }, &decided, &changed);
      if (decided) break;
      absl::Status status = Solve(kInnerIterations, kRoughCostChange);
      if (!status.ok()) return status;
      Measure();
    }
    return absl::OkStatus();
  }

  const Problem& problem_;
  const Options& options_;
  LeastSquares& least_squares_;
  const std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::vector<size_t> edges_, anchors_;  // Indices of edges and anchors in doubt.
  std::vector<double> chi2_;             // In their order, edges first.
  bool done_ = false;
};

}  // namespace

double GncWeight(double chi2, double limit, double mu) {
  if (chi2 <= mu / (mu + 1) * limit) return 1;
  if (chi2 >= (mu + 1) / mu * limit) return 0;
  return std::clamp(std::sqrt(limit / chi2 * mu * (mu + 1)) - mu, 0.0, 1.0);
}

absl::StatusOr<GncOutcome> SolveWithGnc(const Problem& problem, const Options& options,
                                        LeastSquares* least_squares) {
  Gnc gnc(problem, options, least_squares);
  const absl::Status status = gnc.Run();
  if (!status.ok()) return status;
  return gnc.outcome;
}

}  // namespace isthmus::pose_graph
