// A robot that asks where it is in the map that others made.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>

#include "core/point_payload.h"
#include "core/records/localisation.h"

namespace isthmus::client {

struct LocalisationOptions {
  // Sends x, y, z rounded to this, compressed; 0: as they are.
  double resolution_m = 0.002;
};

// Not thread safe. When the link is lost it is opened again, with back-off, and the robot is looked
// for anew: nothing is kept at the server.
class Localisation {
 public:
  ~Localisation();

  // Sends a scan and waits for what is known of its place; stamp is the END of it. InvalidArgument
  // for a payload that cannot be compressed and an unknown sensor, NotFound for an unknown robot to
  // take the map of, FailedPrecondition while there is no map, Unavailable when it was tried
  // backoff.max_attempts times in vain. A scan that cannot be used is no error, see
  // LocalisedScan::rejected.
  absl::StatusOr<LocalisedScan> Locate(int64_t end_stamp_ns, PointPayload payload);

  class Impl;  // Private to the library.
  explicit Localisation(std::unique_ptr<Impl> impl);

 private:
  const std::unique_ptr<Impl> impl_;
};

}  // namespace isthmus::client
