#include "core/floors/rooms.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/floors/basins.h"
#include "core/floors/clutter.h"
#include "core/floors/joining.h"
#include "core/floors/limits.h"
#include "core/floors/necks.h"

namespace isthmus::floors {
namespace {

class RoomFinder {
 public:
  explicit RoomFinder(const GridMap& map)
      : map_(map), ground_(OpenGround(map)), squares_(SquaredDistances(ground_)) {}

  Rooms Find() {
    Basins basins = FindBasins(ground_, squares_);
    JoinBasins(ground_, squares_, map_.resolution_m, &basins);
    Rooms found;
    found.labels = std::move(basins.labels);
    for (const size_t peak : basins.peaks) {
      Room& room = found.rooms.emplace_back();
      const Cell at = ground_.At(peak);
      room.inside = InMap({static_cast<double>(at.x) + 0.5, static_cast<double>(at.y) + 0.5});
    }
    AddAreas(&found);
    AddOutlines(&found);
    AddDoors(&found);
    LabelCorridors(basins.peaks, &found);
    return found;
  }

 private:
  Eigen::Vector2d InMap(const Eigen::Vector2d& cells) const {
    return map_.origin + map_.resolution_m * cells;
  }

  void AddAreas(Rooms* found) const {
    const double cell_m2 = map_.resolution_m * map_.resolution_m;
    for (const int32_t label : found->labels) {
      if (label >= 0) found->rooms[static_cast<size_t>(label)].area_m2 += cell_m2;
    }
  }

  void AddOutlines(Rooms* found) const {
    auto outlines = OutlinesOf(ground_, found->labels, found->rooms.size());
    const double smallest = kSmallestRoomM2 / (map_.resolution_m * map_.resolution_m);
    for (size_t i = 0; i < outlines.size(); ++i) {
      for (Outline& outline : outlines[i]) {
        const double area = SignedArea(outline);
        if (area < 0 && area > -smallest) continue;
        for (Eigen::Vector2d& corner : outline) corner = InMap(corner);
        Room& room = found->rooms[i];
        (area > 0 ? room.outline : room.holes.emplace_back()) = std::move(outline);
      }
    }
  }

  void AddDoors(Rooms* found) const {
    for (const Neck& neck : FindNecks(ground_, squares_, found->labels)) {
      const double width_m = map_.resolution_m * neck.Width();
      if (width_m < kNarrowestDoorM) continue;
      found->doors.push_back(
          {{InMap(neck.ends[0]), InMap(neck.ends[1])}, width_m, {neck.a, neck.b}});
    }
  }

  void LabelCorridors(const std::vector<size_t>& peaks, Rooms* found) const {
    std::vector<int> doors(peaks.size());
    for (const Door& door : found->doors) {
      for (const int32_t room : door.rooms) ++doors[static_cast<size_t>(room)];
    }
    for (size_t i = 0; i < peaks.size(); ++i) {
      const double width_m = 2 * map_.resolution_m * std::sqrt(squares_[peaks[i]]);
      found->rooms[i].is_corridor =
          doors[i] > 1 && found->rooms[i].area_m2 >= kCorridorSquares * width_m * width_m;
    }
  }

  const GridMap& map_;
  Mask ground_;
  std::vector<int32_t> squares_;
};

}  // namespace

absl::StatusOr<Rooms> RoomsOf(const GridMap& map) {
  if (map.width * map.height > kMostRoomCells) {
    return absl::ResourceExhaustedError(
        absl::StrCat("rooms are not looked for in more than ", kMostRoomCells,
                     " cells: give a coarser --resolution, or a --box"));
  }
  return RoomFinder(map).Find();
}

}  // namespace isthmus::floors
