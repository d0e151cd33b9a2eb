// The looks of all placed submaps at each other's points, up to date as they come, move and go.
#pragma once

#include <absl/status/status.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "core/ids.h"
#include "core/lru_cache.h"
#include "core/map/submap.h"
#include "server/composition/box_fields.h"
#include "server/composition/keep_on.h"
#include "server/composition/thinned_submap_cache.h"
#include "server/composition/visibility/submap_views.h"
#include "server/composition/voxel_thinner.h"

namespace isthmus::composition {

// The log odds in WeightedPoint are the sum of what each submap says by itself. So they do not
// depend on the order in which submaps came, and after a move or a removal they are those that a
// map made from nothing would have. Not thread safe.
class VisibilityFilter {
 public:
  // Submaps that moved against each other by no more than `same_pose_m` say the same as before.
  // Views take `max_bytes` of memory, about; others are made again when they are needed.
  VisibilityFilter(double same_pose_m, size_t max_bytes);

  // A submap of which `points` are the thinned ones: fills in what its own views say about them.
  // False when told to end.
  bool JudgeOwn(const Submap& submap, const VoxelGrid& grid, const KeepOn& keep_on,
                std::vector<WeightedPoint>* points);
  // It is in the map, or has moved there. `bounds` of its points, submap frame. Its points are
  // those of JudgeOwn, or were Changed since.
  void Place(const SubmapId& id, uint32_t frame, const Pose& T_map_submap, const Box& bounds);
  // It is in the map no more. No error if it was not.
  void Forget(const SubmapId& id);

  // Told which of a submap's tiles have other points than before.
  using OnChange = std::function<void(const SubmapId& id, const std::vector<size_t>& tiles)>;
  // Brings the points of all submaps in the map up to date. Cancelled when told to stop, else fails
  // as the file does; what is done is done, and the next call goes on from there. The views of a
  // submap that the reader has not say nothing. `at_hand` is set to the submap whose points it is
  // at; of DataLoss it is they that cannot be read back.
  absl::Status Update(const SubmapReader& reader, ThinnedSubmapCache* thinned,
                      const OnChange& on_change, const KeepOn& keep_on,
                      std::optional<SubmapId>* at_hand);

  size_t bytes_in_memory() const { return views_.weight(); }

  // For state_codec.h. Views are made again.
  template <typename Self, typename Io>
  static void Fields(Self& self, Io& io) {
    io(self.entries_, self.judged_);
  }

 private:
  // A submap that was judged.
  struct Judged {
    Box sensors;  // Around its sensor positions, submap frame.
    int64_t first_stamp_ns = 0, last_stamp_ns = 0;

    template <typename Self, typename Io>
    static void Fields(Self& self, Io& io) {
      io(self.sensors, self.first_stamp_ns, self.last_stamp_ns);
    }
  };
  struct Entry {
    uint32_t frame = 0;
    Pose T_map_submap;
    Box bounds;  // Around the points, submap frame.
    Judged judged;
    std::map<SubmapId, Pose> asked;  // Submaps whose views are in the points: T_views_points then.

    template <typename Self, typename Io>
    static void Fields(Self& self, Io& io) {
      io(self.frame, self.T_map_submap, self.bounds, self.judged, self.asked);
    }
  };

  bool Reaches(const Entry& views, const Entry& points) const;
  std::map<SubmapId, Pose> WhomToAsk(const SubmapId& id, const Entry& entry) const;
  std::shared_ptr<const SubmapViews> ViewsOf(const SubmapId& id, const SubmapReader& reader);
  void KeepViews(const SubmapId& id, std::shared_ptr<const SubmapViews> views);
  absl::Status Ask(const SubmapId& id, Entry* entry, const SubmapReader& reader,
                   ThinnedSubmapCache* thinned, const OnChange& on_change, const KeepOn& keep_on);

  const double same_pose_m_;
  const size_t max_bytes_;
  std::map<SubmapId, Entry> entries_;
  std::map<SubmapId, Judged> judged_;
  std::set<SubmapId> changed_;    // Came, moved or went since the last Update that ended.
  std::set<SubmapId> forgotten_;  // Went since then; others may have come by their ids.
  LruCache<SubmapId, std::shared_ptr<const SubmapViews>> views_;
};

}  // namespace isthmus::composition
