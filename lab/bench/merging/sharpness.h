// The sharpness of robots' common map: how thick its walls are, and how far apart two robots have
// the same wall; as the server placed the submaps, as they lie in truth, and after an alignment of
// each with all around it, which says what a further refinement of the map could bring.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "lab/bench/merging/driven_robot.h"
#include "server/pipeline.h"

namespace isthmus::bench {

// Pieces of surface: points of two or more submaps within half a metre that are flat, all lying as
// they do in truth. The same points make a piece whatever the poses.
struct Sharpness {
  // Standard deviation of a piece's points across it: the median, and of one piece in twenty more.
  double thickness_m = 0, thick_m = 0;
  // The distance, across a piece that both of the first two robots saw, between the middles of
  // their points, likewise.
  double apart_m = 0, far_apart_m = 0;
};

struct SharpnessFigures {
  size_t pieces = 0;
  size_t shared = 0;  // By the first two robots.
  Sharpness in_truth, in_map, aligned_again;
};

// The submaps that are in the map count; all must be in one component. Nothing, zeros, where no
// piece was seen twice.
SharpnessFigures MeasureSharpness(const std::vector<DrivenRobot>& robots,
                                  server::Pipeline& pipeline);

// A row of the table.
struct MapSharpness {
  std::string map;
  uint64_t seed = 0;
  SharpnessFigures figures;
};

// In millimetres. Rows without pieces are left out; empty where none is left.
std::string SharpnessTable(const std::vector<MapSharpness>& maps);
nlohmann::ordered_json ToJson(const SharpnessFigures& figures);

}  // namespace isthmus::bench
