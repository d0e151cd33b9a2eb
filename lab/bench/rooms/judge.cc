#include "lab/bench/rooms/judge.h"

#include <algorithm>
#include <map>
#include <utility>

namespace isthmus::bench {
namespace {

constexpr double kNearM = 0.5;  // A door that is found.

// The mean over rooms of the largest share of a room's cells that one room of the other side has.
double MeanShare(const std::vector<int32_t>& rooms, const std::vector<int32_t>& others,
                 const floors::GridMap& ground) {
  std::map<int32_t, int64_t> sizes, largest;
  std::map<std::pair<int32_t, int32_t>, int64_t> shared;
  for (size_t i = 0; i < rooms.size(); ++i) {
    if (rooms[i] < 0 || ground.cells[i] != floors::GridCell::kFree) continue;
    ++sizes[rooms[i]];
    if (others[i] >= 0) ++shared[{rooms[i], others[i]}];
  }
  for (const auto& [pair, count] : shared) {
    largest[pair.first] = std::max(largest[pair.first], count);
  }
  double sum = 0;
  for (const auto& [room, size] : sizes) {
    sum += static_cast<double>(largest[room]) / static_cast<double>(size);
  }
  return sizes.empty() ? 0 : sum / static_cast<double>(sizes.size());
}

bool IsNear(const Eigen::Vector2d& place, const std::vector<Eigen::Vector2d>& others) {
  return std::any_of(others.begin(), others.end(), [&place](const Eigen::Vector2d& other) {
    return (place - other).norm() <= kNearM;
  });
}

int64_t CountNear(const std::vector<Eigen::Vector2d>& places,
                  const std::vector<Eigen::Vector2d>& others) {
  return std::count_if(places.begin(), places.end(),
                       [&others](const Eigen::Vector2d& place) { return IsNear(place, others); });
}

}  // namespace

void RoomScore::Add(const RoomScore& other) {
  true_rooms += other.true_rooms;
  found_rooms += other.found_rooms;
  recall += other.recall;
  precision += other.precision;
  true_doors += other.true_doors;
  doors_found += other.doors_found;
  found_doors += other.found_doors;
  doors_right += other.doors_right;
}

RoomScore JudgeRooms(const floors::Rooms& found, const TrueRooms& truth,
                     const floors::GridMap& ground) {
  RoomScore score{.found_rooms = static_cast<int64_t>(found.rooms.size())};
  const auto last = std::max_element(truth.labels.begin(), truth.labels.end());
  score.true_rooms = last == truth.labels.end() ? 0 : *last + 1;
  score.recall = MeanShare(truth.labels, found.labels, ground);
  score.precision = MeanShare(found.labels, truth.labels, ground);
  std::vector<Eigen::Vector2d> doors;
  for (const floors::Door& door : found.doors) doors.push_back((door.ends[0] + door.ends[1]) / 2);
  score.true_doors = static_cast<int64_t>(truth.doors.size());
  score.doors_found = CountNear(truth.doors, doors);
  score.found_doors = static_cast<int64_t>(doors.size());
  score.doors_right = CountNear(doors, truth.doors);
  return score;
}

}  // namespace isthmus::bench
