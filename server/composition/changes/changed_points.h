// Points that one side of a comparison has seen and the other looked through.
//
// Unknown is not changed: where the other side never looked, nothing is said.
#pragma once

#include <absl/status/statusor.h>

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/map/composed_map.h"
#include "core/map/submap.h"
#include "server/composition/keep_on.h"

namespace isthmus::composition {

// Submaps of one component, and which side of the comparison each is of.
struct ComparedSubmap {
  PlacedSubmap placed;
  bool is_after = false;
};

struct ChangedPoint {
  Eigen::Vector3f at;      // The middle of a voxel, map frame.
  bool came = false;       // Seen after, looked through before; else the reverse.
  uint32_t seen_by = 0;    // Index of the first submap that saw it ...
  uint32_t missed_by = 0;  // ... and of the one whose time missing_ns is.
  uint32_t hits = 0;       // Keyframes of its side that saw it, ...
  uint32_t passes = 0;     // ... and of the other side that did.
  Eigen::Vector3f inward = Eigen::Vector3f::Zero();  // Across its surface, away from who saw it.
  uint32_t passes_behind = 0;         // The other side's passes kPassedBehindM that way.
  int64_t first_ns = 0, last_ns = 0;  // When the part of the world around it was seen.
  int64_t missing_ns = 0;  // Looked through: the first time for what went, the last for what came.
  // To the nearest voxel that the other side has seen, within kDriftedVoxels; else infinite.
  Eigen::Vector3f to_other = Eigen::Vector3f::Constant(std::numeric_limits<float>::infinity());
};

// Points lie in `region`, of which box, sphere and shape are looked at. Left out is what lies
// within kStillThereVoxels of something that the other side has seen, floors and ceilings, what
// fewer than kFewestPasses keyframes of the other side looked through, and what moves, by its own
// side's looks. Submaps that the reader has not are left out. Cancelled when told to end;
// ResourceExhausted where there is too much to compare, saying what to do. Submaps are read twice,
// one after the other.
absl::StatusOr<std::vector<ChangedPoint>> FindChangedPoints(
    const std::vector<ComparedSubmap>& submaps, const SubmapReader& reader, const Region& region,
    const KeepOn& keep_on);

}  // namespace isthmus::composition
