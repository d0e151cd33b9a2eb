// A scan in the making: records of points, each with its exact time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "client/readers/scan_reader.h"
#include "core/point_payload.h"

namespace isthmus::readers {

// Packed records: x y z intensity (float32), ring (uint16), time (float32, seconds before the END),
// then what the sensor has more. Not thread safe.
class ScanBuilder {
 public:
  struct Record {
    float x, y, z, intensity;
    uint16_t ring;
  };

  explicit ScanBuilder(const std::vector<PointField>& more = {});

  bool empty() const { return times_.empty(); }
  size_t size() const { return times_.size(); }
  int64_t first_ns() const { return times_.front(); }  // The point that was added first.

  // Returns where the fields `more` go, at their offsets in the record; good until the next Add.
  char* Add(const Record& point, int64_t time_ns);

  // The scan, whose END is that of the latest point; the builder is empty then. `offset_ns` is
  // added to make Unix time of the times. Not of an empty one.
  RecordedScan Finish(int64_t offset_ns);

 private:
  std::vector<PointField> fields_;
  uint32_t stride_ = 0;
  std::string data_;
  std::vector<int64_t> times_;
  uint64_t scans_ = 0;
};

}  // namespace isthmus::readers
