// Chords between neighbouring rings: the surface that a ring crosses, continued to the rings beside
// it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "floam/rings/ring_scan.h"
#include "floam/scan/work.h"

namespace isthmus::floam {

struct TimedPoint;

// Unit vectors from a point to where the next ring on either side was hit at its azimuth, or the
// one after. Zero where nothing was; NaN where that stands much nearer or farther: behind what is
// in the way the surface may go on.
using RingChords = std::array<Eigen::Vector3f, 2>;

// The chords of every point of `points`, which are of that scan. Empty without rings. Adds to
// `*work`, and ends half done once that is spent.
std::vector<RingChords> ChordsOf(const RingScan& scan, const std::vector<TimedPoint>& points,
                                 Work* work);

// True if a plane of that normal (sensor frame) may be the one that is seen: it lies along one of
// the chords. A voxel that few rings crossed may hold any plane through these, and of points that
// were put there when the sensor was thought to pitch, steep ones on a level floor.
bool MayBe(const RingChords& chords, const Eigen::Vector3f& normal);

}  // namespace isthmus::floam
