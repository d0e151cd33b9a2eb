// A guess of the sensor from the rings of its scans.
#pragma once

#include <cstddef>
#include <string>

#include "core/point_payload.h"

namespace isthmus::readers {

// Takes scans, one after the other. Not thread safe.
class RingSensor {
 public:
  // Looks at the first few. The payload is raw and its layout was checked.
  void Look(const PointPayload& payload);
  // "livox" for the fields of its driver, else the smallest usual model with as many rings as the
  // scans have; empty where nothing tells.
  std::string sensor() const;

 private:
  size_t scans_ = 0;
  double highest_ = -1;
  bool livox_ = false;
};

}  // namespace isthmus::readers
