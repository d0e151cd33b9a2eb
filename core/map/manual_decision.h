// A person's decision on a pair of sessions, which no computed match overrules.
#pragma once

#include <cstdint>
#include <string>

#include "core/ids.h"
#include "core/pose.h"

namespace isthmus {

enum class ManualDecisionKind {
  kAccept,  // The transform that was computed holds.
  kReject,  // The pair is not joined, whatever is computed.
  kSet,     // The transform given by hand holds.
};

// Stable upper-case name ("ACCEPT"); used in JSON, storage and messages.
const char* ToString(ManualDecisionKind kind);

// On the ordered pair (a, b), a < b.
struct ManualDecision {
  SessionId a;
  SessionId b;
  ManualDecisionKind kind = ManualDecisionKind::kReject;
  // Takes a point of b's odom frame to a's: what was accepted or given; where the pair was
  // rejected, what was computed then. Later computations do not change it.
  Pose T_a_b;
  std::string note;      // Why, in the person's own words; may be empty.
  int64_t given_ns = 0;  // Unix nanoseconds.
};

}  // namespace isthmus
