// OctoMaps of the map as it is, of evidence that is kept from one to the next.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <vector>

#include "core/concurrency/mutex.h"
#include "core/map/composed_map.h"
#include "core/map/free_space.h"
#include "server/composition/occupancy/evidence_layer.h"
#include "server/composition/occupancy/occupancy_options.h"
#include "server/composition/occupancy/octomap_file.h"

namespace isthmus::composition {

// Keeps the columns of evidence in memory that were asked for last, each with the submaps and poses
// that it is made of. Thread safe: nobody waits while rays are cast; two callers that ask for the
// same at once both cast.
class KeptOccupancy {
 public:
  // Kept evidence takes so much memory at most; 0: nothing is kept.
  explicit KeptOccupancy(uint64_t max_kept_bytes) : max_kept_bytes_(max_kept_bytes) {}

  struct Cost {
    uint64_t missing = 0;       // Submaps that the reader had not; they are left out.
    uint64_t columns_cast = 0;  // Not found among what is kept.
  };

  // The file's bytes: those of OctoMap's own writer, one hit or miss per voxel and keyframe, of the
  // component's submaps in the order given. They do not depend on what was written before, as long
  // as the sensor model is the same. A component without submaps gives the file of an empty tree.
  //
  // InvalidArgument for options out of range. OutOfRange when the map reaches farther than the
  // 2^15 voxels from the origin that the format can tell apart. ResourceExhausted when more than
  // options.max_bytes would be needed. Cancelled by options.region.keep_on.
  absl::StatusOr<std::string> Write(const std::vector<PlacedSubmap>& submaps,
                                    const SubmapReader& reader, uint32_t component,
                                    OccupancyFormat format, const OccupancyOptions& options,
                                    Cost* cost = nullptr);
  // The leaves of the kBinary file, without the file; ResourceExhausted also where its tree would
  // have more than so many bytes.
  absl::StatusOr<FreeSpace> Read(const std::vector<PlacedSubmap>& submaps,
                                 const SubmapReader& reader, uint32_t component,
                                 const OccupancyOptions& options, uint64_t max_file_bytes);

  uint64_t kept_bytes() const;

 private:
  using Layer = std::shared_ptr<const EvidenceLayer>;

  using Columns = std::vector<PlacedColumn>;

  // The result of `make`, which is given the columns of the region, and the bytes of memory left.
  template <typename Made>
  absl::StatusOr<Made> Make(
      const std::vector<PlacedSubmap>& submaps, const SubmapReader& reader, uint32_t component,
      const OccupancyOptions& options, Cost* cost,
      const std::function<absl::StatusOr<Made>(const Columns& columns, uint64_t bytes)>& make);
  // The layer with most of the submaps at their poses; null if none has any.
  Layer Find(const std::vector<const PlacedSubmap*>& submaps,
             const OccupancyOptions& options) const;
  // In place of `before`, unless that is null or gone.
  void Keep(const Layer& before, EvidenceLayer layer);

  const uint64_t max_kept_bytes_;
  mutable Mutex mutex_;
  std::list<Layer> layers_ ABSL_GUARDED_BY(mutex_);  // The one asked for last first.
};

// The same as KeptOccupancy::Write, without kept evidence.
absl::StatusOr<std::string> WriteOccupancy(const std::vector<PlacedSubmap>& submaps,
                                           const SubmapReader& reader, uint32_t component,
                                           OccupancyFormat format, const OccupancyOptions& options,
                                           uint64_t* missing = nullptr);

}  // namespace isthmus::composition
