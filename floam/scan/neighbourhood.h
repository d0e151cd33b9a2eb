// The neighbourhood of a scan's point where there are no rings to follow.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "floam/rings/ring_scan.h"

namespace isthmus::floam {

enum class Surroundings {
  kUnclear,  // A border, a corner, leaves, or too little was seen.
  kSurface,  // On a plane that is not seen at grazing incidence.
  kEdge,     // On something slim, a pole, with the background to be seen on both sides of it.
};

// Neighbours are those in direction, as seen from the sensor: on a grid of the sphere whose cells
// are as large as the scan's density makes them. A plane is one in inverse range too: with axis x
// towards the point, a plane in space is 1 / x = a + b (y / x) + c (z / x), linear in what is
// sought. Motion of the sensor changes 1 / x by about so much per second for all neighbours, which
// is one more unknown: that pattern which does not repeat looks at a place early and late in the
// scan does no harm. Building takes time linear in the points, looking as long as there are
// neighbours. Not thread safe: holds scratch memory.
class Neighbourhoods {
 public:
  // `scan` must stay as and where it is for as long as it is looked at. Points with coordinates
  // that are not finite are nobody's neighbours.
  void Build(const RingScan& scan);

  struct Look {
    Surroundings are = Surroundings::kUnclear;
    float deviation_m = 0;  // Distance of the neighbours from the plane, root mean square.
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // The plane's, towards the sensor.
    size_t neighbours = 0;                             // Neighbours that were looked at.
  };
  // The neighbourhood of a point of the scan. Neighbours may be off a plane by `deviation_m` (root
  // mean square), and a little more the farther away they are.
  Look At(uint32_t index, float deviation_m);

 private:
  // A neighbour: what the unknowns are multiplied by, and what should come out; see FitPlane.
  struct Neighbour {
    Eigen::Array4f row;
    float w;
  };
  struct Cell {
    uint16_t row = 0, column = 0;
  };

  void ChooseCells(const RingScan& scan);
  void Sort(const RingScan& scan);
  void Gather(const RingPoint& point, const Cell& cell);
  bool FitPlane(const RingPoint& point, Look* look) const;
  bool IsSlim(const RingPoint& point);

  const RingScan* scan_ = nullptr;
  float cell_rad_ = 0;
  size_t stride_ = 1;                    // Above 1 if every so manieth point of a scan is enough.
  std::vector<Eigen::Vector2f> angles_;  // Per point: azimuth and elevation.
  std::vector<Cell> cells_;              // Per point.
  std::vector<uint32_t> row_begin_;      // The first cell of each row, and the end of the last.
  std::vector<uint32_t> cell_begin_;     // The first entry of each cell, and the end of the last.
  std::vector<Eigen::Array4f> entries_;  // Position and time.

  // State for the point at hand.
  Eigen::Matrix3f axes_;  // Columns: towards the point, to the left, up.
  std::vector<Neighbour> near_, beside_;
  std::vector<Eigen::Vector2f> strip_, background_;  // Directions, in cells.
};

}  // namespace isthmus::floam
