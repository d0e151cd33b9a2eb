// What the surroundings of a point of a scan look like, where there are no rings to go along.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "floam/ring_scan.h"

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
// scan does no harm. Building takes time linear in the points, looking constant time. Not thread
// safe: holds scratch memory.
class Neighbourhoods {
 public:
  // `scan` must stay as it is for as long as it is looked at. Points with coordinates that are not
  // finite are nobody's neighbours.
  void Build(const RingScan& scan);

  struct Look {
    Surroundings are = Surroundings::kUnclear;
    float deviation_m = 0;  // Root mean square distance of the neighbours from the plane.
  };
  // Of a point of the scan. Neighbours may be off a plane by `deviation_m` (root mean square).
  Look At(const RingPoint& point, float deviation_m);

 private:
  struct Entry {
    float x, y, z, time;
  };
  // A neighbour in axes with x towards the point: directions, and range over that of the point.
  struct Neighbour {
    float y, z, x, time;
  };

  void ChooseCells(const RingScan& scan);
  int RowOf(float elevation) const;
  int ColumnOf(float azimuth, int row) const;
  void Gather(const RingPoint& point);
  bool FitPlane(const RingPoint& point, float* deviation_m) const;
  bool IsSlim(const RingPoint& point) const;

  float cell_rad_ = 0;
  size_t stride_ = 1;               // Of scans so dense that every so manieth point is enough.
  std::vector<uint32_t> row_cell_;  // The first cell of each row, and the end of the last.
  std::vector<uint32_t> begin_;     // Of each cell's entries, and the end of the last.
  std::vector<Entry> entries_;
  std::vector<uint32_t> cell_of_;

  // Of the point at hand.
  std::vector<Neighbour> near_, all_;
};

}  // namespace isthmus::floam
