// Pose graphs with a known truth, of the shapes that public benchmarks have.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/pose_graph/problem.h"

namespace isthmus::bench {

struct BenchmarkGraph {
  std::string name;
  pose_graph::Problem problem;  // Edges that are not odometry may be wrong.
  std::vector<Pose> truth;      // Empty where it is not known (files).
};

// 50 rounds of 50 nodes up a sphere of 50 m radius; closures to the round below. Odometry turns by
// 3 degrees (one standard deviation) from node to node: the start is a tangle.
BenchmarkGraph SphereGraph(uint64_t seed);

// Five floors of a garage, each driven three times round in neighbouring lanes, joined by ramps;
// closures between lanes of a floor, none between floors.
BenchmarkGraph GarageGraph(uint64_t seed);

// A drive over the streets of a campus of 7 x 7 crossings, 60 m apart, turning at random: 2,000
// nodes every 8 m, and 6,000 edges: odometry, and closures drawn from all pairs closer than 10 m.
BenchmarkGraph CampusGraph(uint64_t seed);

// Appends false closures between any nodes, relative poses of a few metres, until they are `share`
// of all closures.
void AddFalseClosures(double share, uint64_t seed, BenchmarkGraph* graph);

// Root mean square distance of positions after the rigid alignment that makes it least (Umeyama).
double AlignedRmse(const std::vector<Pose>& poses, const std::vector<Pose>& truth);

}  // namespace isthmus::bench
