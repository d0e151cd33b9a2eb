// The score of two sessions' plans, laid on each other as well as they fit: by it partners are
// ranked.
#pragma once

#include <stop_token>

#include "server/matching/index/plan_correlator.h"
#include "server/matching/index/session_plan.h"

namespace isthmus::matching {

// Comparable between pairs; 0 where nothing fits, or if asked to stop. That plans fit says that it
// is worth a search and no more: so do plans of look-alikes. Some 20 ms for maps of 50 m.
// Deterministic; thread safe.
double ComparePlans(const SessionPlan& a, const SessionPlan& b, const std::stop_token& stop = {});

// The same with where b lies on a.
PlanarPose PlacePlan(const SessionPlan& a, const SessionPlan& b, const std::stop_token& stop = {});

}  // namespace isthmus::matching
