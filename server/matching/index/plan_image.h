// Plans drawn for the correlation.
#pragma once

#include <array>
#include <vector>

#include "server/matching/index/session_plan.h"

namespace isthmus::matching {

// Square planes that wrap round, whose products with another plan's, summed, are the score of a
// placement. The plan's centre is at cell (0, 0).
struct PlanImage {
  enum Plane { kNormalX, kNormalY, kWall, kFreeOnBlocking, kBlockingOnFree, kPlanes };
  std::array<std::vector<float>, kPlanes> planes;  // Row by row.
};

// The plan that stays: blurred, so that neighbours of a wall agree a little.
PlanImage MakeReference(const SessionPlan& plan, int size);

PlanImage MakeMoved(const SessionPlan& plan, double yaw, int size);

// Blurs a square plane by a cell along either axis, the peak staying 1.
void BlurPlane(int size, std::vector<float>* plane);

}  // namespace isthmus::matching
