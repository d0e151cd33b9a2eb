// The score of two sessions' plans, laid on each other as well as they fit: by it partners are
// ranked.
#pragma once

#include <memory>
#include <stop_token>

#include "server/matching/index/plan_correlator.h"
#include "server/matching/index/session_plan.h"

namespace isthmus::matching {

// A plan that is compared with others: the tenth one costs less than the first. Not thread safe.
class PlanComparer {
 public:
  explicit PlanComparer(std::shared_ptr<const SessionPlan> plan)
      : plan_(plan), correlator_(std::move(plan)) {}

  // Comparable between pairs; 0 where nothing fits, or if asked to stop. That plans fit says that
  // it is worth a search and no more: so do plans of look-alikes. Which of the two is which makes
  // it a few per cent more or less. Deterministic, whatever was compared before.
  double Score(const SessionPlan& other, const std::stop_token& stop = {}) {
    return PlaceOn(other, stop).score;
  }

  // The same with where the plan lies on the other.
  PlanarPose PlaceOn(const SessionPlan& other, const std::stop_token& stop = {});

 private:
  const std::shared_ptr<const SessionPlan> plan_;
  PlanCorrelator correlator_;
};

}  // namespace isthmus::matching
