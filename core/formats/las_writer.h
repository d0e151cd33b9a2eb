// Clouds as LAS 1.4 files (ASPRS LAS Specification 1.4 R15), piece by piece.
#pragma once

#include <absl/status/status.h>

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/cloud.h"
#include "core/ids.h"

namespace isthmus::formats {

struct LasOptions {
  // In the order of MapPoint::robot; point_source_id is that index plus one, because 0 stands for
  // the file itself. Listed in the Text Area Description record. At most 65534.
  std::vector<RobotId> robots = {};
  // The coordinate reference system of x, y and z, WKT 1 (OGC 01-009); empty: none is named.
  std::string wkt = {};
  // Added to points before they are stored: where large coordinates begin. Whole metres are best.
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  std::string software = "isthmus";  // At most 31 characters.
  int64_t created_ns = 0;            // Unix; only its day is kept.
};

// Point format 6, a point its only return, one millimetre of resolution, no GPS time (0).
// Classification is 2 for ground, 5 for vegetation of any height, 6 for walls, 1 for what is
// unknown; numbers from 64 on are named in the Classification Lookup record. Intensities are scaled
// to 16 bits by a factor that the first piece of points decides: 65535 where all are within [0, 1],
// 257 within [0, 255], 1 otherwise; what is beyond is clamped. The factor is in the Text Area
// Description. A point beyond what 32 bits of millimetres hold (2147 km from the offset) or not
// finite is left out. Not thread safe.
//
// A file is Header(), then what Points() gave; the header tells count and bounds, so it is right
// only after the last points, with the same size as before them: HeaderSize() bytes.
class LasWriter {
 public:
  explicit LasWriter(LasOptions options);

  std::string Header() const;
  size_t HeaderSize() const { return Header().size(); }
  // Coordinates are metres, as `position(point)` gives them in the system that the WKT names.
  template <typename Position>
  std::string Points(const std::vector<MapPoint>& points, const Position& position) {
    std::string records;
    records.reserve(points.size() * kRecordSize);
    ChooseFactor(points);
    for (const MapPoint& point : points) Append(position(point), point, &records);
    return records;
  }
  uint64_t count() const { return count_; }

 private:
  static constexpr size_t kRecordSize = 30;  // Point format 6, table 15.

  void ChooseFactor(const std::vector<MapPoint>& points);
  void Append(const Eigen::Vector3d& position, const MapPoint& point, std::string* records);

  const LasOptions options_;
  float intensity_factor_ = 0;  // 0: no points yet.
  uint64_t count_ = 0;
  Eigen::Array3d min_, max_;  // In steps, once there is a point.
};

}  // namespace isthmus::formats
