#include "lab/simulation/wild/plan.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lab/simulation/wild/shapes.h"

namespace isthmus::simulation::wild {
namespace {

// A loop from the door to the far end of the room and back, somewhere near the door: what is left
// at the walls is for furniture. Offices without inner walls are walked all around.
std::vector<Eigen::Vector2d> Round(const PlannedRoom& room, const Passage& passage,
                                   Random& random) {
  constexpr double kNarrowest = 0.5;
  const Eigen::Vector2d size = room.Size();
  const bool open_plan = room.use == RoomUse::kOpenPlan && size.minCoeff() > 6;
  const double wish = passage.base_m / 2 + (open_plan ? 1.7 : random.Uniform(0.75, 1.1));
  const Eigen::Vector2d inset = (size.array() / 2 - kNarrowest / 2).min(wish).max(0.3).matrix();
  const double low = room.min.x() + inset.x(), high = room.max.x() - inset.x();
  double wide = high - low;
  if (!open_plan) wide = std::min(wide, random.Uniform(kNarrowest, 1.2));
  const double left = std::clamp(room.door_x - wide * random.Unit(), low, high - wide);
  const double far_end = size.y() - inset.y();
  const double near = std::min(passage.base_m / 2 + 0.5, far_end - kNarrowest);
  // Some only look in.
  const double far = open_plan ? far_end : near + random.Uniform(0.4, 1) * (far_end - near);
  return {room.Behind(room.door_x, near), room.Behind(left, near),
          room.Behind(left, far),         room.Behind(left + wide, far),
          room.Behind(left + wide, near), room.Behind(room.door_x, near)};
}

// The corners of the flights up from a storey, from the door of the stairs to the door above.
std::vector<Eigen::Vector3d> FlightsUp(const Plan& plan, const PlannedRoom& stairs, int storey) {
  const double z = storey * plan.storey_m, middle = z + plan.storey_m / 2, top = z + plan.storey_m;
  const double landing = plan.landing_m(), far = landing + plan.run_m(stairs);
  const double up_x = stairs.door_x - plan.flight_m / 2, down_x = stairs.door_x + plan.flight_m / 2;
  std::vector<Eigen::Vector3d> corners;
  const auto add = [&](double x, double into, double height) {
    const Eigen::Vector2d at = stairs.Behind(x, into);
    corners.push_back({at.x(), at.y(), height});
  };
  add(stairs.door_x, landing / 2, z);
  add(up_x, landing / 2, z);
  add(up_x, landing, z);
  add(up_x, far, middle);
  add(up_x, far + landing / 2, middle);
  add(down_x, far + landing / 2, middle);
  add(down_x, far, middle);
  add(down_x, landing, top);
  add(down_x, landing / 2, top);
  add(stairs.door_x, landing / 2, top);
  return corners;
}

}  // namespace

const PlannedRoom* Plan::stairs() const {
  for (const PlannedRoom& room : rooms) {
    if (room.use == RoomUse::kStairs) return &room;
  }
  return nullptr;
}

void AddRow(const RowOfRooms& row, const Passage& passage, Random& random, Plan* plan) {
  double x = 0;
  const double wall = plan->corridor_m / 2;
  for (const auto& [use, width] : row.rooms) {
    PlannedRoom room{.use = use, .north = row.north};
    room.min = {x, row.north ? wall : -wall - row.depth_m};
    room.max = {x + width, row.north ? wall + row.depth_m : -wall};
    const double margin = std::min(plan->door_m / 2 + 0.25, width / 2);
    const double off = random.Uniform(margin, width - margin);
    room.door_x = x + (use == RoomUse::kStairs ? width / 2 : off);
    room.round = Round(room, passage, random);
    plan->rooms.push_back(std::move(room));
    x += width;
  }
  plan->length_m = std::max(plan->length_m, x);
}

std::vector<Eigen::Vector3d> StrollThrough(const Plan& plan, const Outing& outing, Random& random) {
  std::vector<const PlannedRoom*> rooms;
  for (const PlannedRoom& room : plan.rooms) {
    const bool in_reach = room.door_x >= outing.from_x && room.door_x <= outing.to_x;
    if (room.use != RoomUse::kStairs && in_reach) rooms.push_back(&room);
  }
  if (rooms.empty()) rooms.push_back(&plan.rooms.front());
  std::vector<Eigen::Vector3d> corners;
  double length = 0;
  const auto go = [&](const Eigen::Vector3d& to) {
    if (!corners.empty()) length += (corners.back() - to).norm();
    corners.push_back(to);
  };
  const PlannedRoom* stairs = outing.climbs ? plan.stairs() : nullptr;
  int storey = stairs != nullptr ? random.Index(plan.storeys) : 0;
  const PlannedRoom* last = nullptr;
  double x = random.Uniform(outing.from_x, outing.to_x);
  while (length < outing.length_m) {
    const double y = random.Uniform(-outing.aside_m, outing.aside_m), z = storey * plan.storey_m;
    go({x, y, z});
    const bool climbs = stairs != nullptr && last != stairs && random.Chance(0.3);
    const PlannedRoom* next = stairs;
    while (!climbs && (next == stairs || (next == last && rooms.size() > 1))) {
      next = rooms[random.Index(static_cast<int>(rooms.size()))];
    }
    go({next->door_x, y, z});
    if (climbs) {
      const bool up = storey == 0 || (storey + 1 < plan.storeys && random.Chance(0.5));
      auto flights = FlightsUp(plan, *stairs, up ? storey : storey - 1);
      if (!up) std::reverse(flights.begin(), flights.end());
      for (const Eigen::Vector3d& corner : flights) go(corner);
      storey += up ? 1 : -1;
    } else {
      std::vector<Eigen::Vector2d> round = next->round;
      if (random.Chance(0.5)) std::reverse(round.begin(), round.end());
      for (const Eigen::Vector2d& corner : round) go({corner.x(), corner.y(), z});
    }
    last = next;
    x = next->door_x;
  }
  return corners;
}

}  // namespace isthmus::simulation::wild
