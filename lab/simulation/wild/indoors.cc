// Furnished storeys: flats, offices, and storeys of large buildings with stairs between them.
#include <algorithm>
#include <cmath>

#include "lab/simulation/wild/furnish.h"
#include "lab/simulation/wild/plan.h"
#include "lab/simulation/wild/scenes.h"

namespace isthmus::simulation::wild {
namespace {

using enum RoomUse;

// Clearance of a robot beside its way: less than out of doors, as people leave it at home.
double ClearM(const Need& need) { return need.carrier.base_m / 2 + 0.3; }

Passage PassageOf(const Need& need) { return {need.carrier.base_m, need.carrier.height_m}; }

// A storey without rooms, `high_m` from floor to ceiling or as high as is needed.
Plan EmptyPlan(const Need& need, double corridor_m, double high_m) {
  Plan plan;
  plan.corridor_m = std::max(corridor_m, need.carrier.base_m + 0.8);
  plan.storey_m = std::max(high_m, need.clear_height_m() + 0.2) + plan.slab_m;
  plan.door_m = std::max(1.0, need.carrier.base_m + 0.5);
  plan.door_high_m =
      std::min(plan.clear_height() - 0.05, std::max(2.05, need.carrier.height_m + 0.4));
  plan.flight_m = std::max(1.2, need.carrier.base_m + 0.6);
  return plan;
}

// Rooms of `widths` side by side, stretched to fill the length.
RowOfRooms Fill(bool north, double depth_m, double length_m, std::vector<RowOfRooms::Wish> rooms) {
  double sum = 0;
  for (const auto& room : rooms) sum += room.width_m;
  for (auto& room : rooms) room.width_m *= length_m / sum;
  return {north, depth_m, std::move(rooms)};
}

// Somewhere along the corridor, in part of the building or all of it.
Outing DrawOuting(const Plan& plan, const Need& need, Random& random) {
  const double half = random.Uniform(0.2, 0.6) * plan.length_m;
  const double middle = random.Uniform(0.15, 0.85) * plan.length_m;
  Outing outing;
  outing.from_x = std::max(0.6, middle - half);
  outing.to_x = std::min(plan.length_m - 0.6, middle + half);
  outing.length_m = need.path_length_m + 20;
  outing.climbs = need.climbs();
  outing.aside_m = std::max(0.0, 0.7 * (plan.corridor_m / 2 - need.carrier.base_m / 2 - 0.4));
  return outing;
}

// Ways, people, walls and furniture.
Scene Inhabit(const Plan& plan, const Need& need, int most_people, Random& random) {
  constexpr double kRoundM = 0.4;
  Scene scene;
  const auto way = [&](const Outing& outing) {
    return std::make_shared<Path>(Path::Along(StrollThrough(plan, outing, random), kRoundM));
  };
  std::vector<std::shared_ptr<const Path>> ways;
  for (int robot = 0; robot < need.robots; ++robot) {
    scene.ways.push_back(way(DrawOuting(plan, need, random)));
    ways.push_back(scene.ways.back());
  }
  scene.path = scene.ways.front();
  const bool climbs = need.climbs() && plan.stairs() != nullptr;
  if (!climbs) {  // All storeys are walked alike.
    scene.storeys = plan.storeys;
    scene.storey_m = plan.storey_m;
    for (int storey = 1; storey < plan.storeys; ++storey) {
      for (const auto& below : scene.ways) {
        ways.push_back(std::make_shared<Path>(below->Moved(0, storey * plan.storey_m)));
      }
    }
  }
  const int people = random.Chance(0.4) ? 0 : random.Index(most_people + 1);
  for (int i = 0; i < people; ++i) {
    Outing outing = DrawOuting(plan, need, random);
    outing.length_m = 60;
    outing.climbs = false;
    const auto walk = std::make_shared<const Path>(
        way(outing)->Moved(0, random.Index(plan.storeys) * plan.storey_m));
    ways.push_back(walk);
    const double speed = random.Uniform(0.5, 1.5);
    scene.walks.push_back(WalkToAndFro(walk, speed, random.Uniform(0, walk->length())));
  }
  scene.give_way_m = need.carrier.base_m / 2 + 0.45;
  AddPlanTo(plan, random, &scene.mesh);
  if (!need.bare) FurnishPlan(plan, need.season, ClearM(need), Trodden(ways), &scene.mesh);
  return scene;
}

}  // namespace

Scene MakeFlat(const Need& need, Random& random) {
  Plan plan = EmptyPlan(need, random.Uniform(1.1, 1.6), random.Uniform(2.35, 2.8));
  const int rooms = 2 + random.Index(4);
  // The rooms of either side in turn; a bath has a neighbour, so that it is small.
  const std::vector<RoomUse> uses = {kLiving, rooms < 4 ? kBed : kBath, kKitchen, kBed, kBed};
  const double area = std::clamp(rooms * random.Uniform(13, 23) + 6, 40.0, 120.0);
  const double deep[2] = {random.Uniform(3.2, 5.2), random.Uniform(2.8, 4.6)};
  plan.length_m = area / (deep[0] + deep[1] + plan.corridor_m);
  std::vector<RowOfRooms::Wish> rows[2];
  for (int i = 0; i < rooms; ++i) {
    const double wide = uses[i] == kBath ? 2.2 : random.Uniform(3, 4.5);
    rows[i % 2].push_back({uses[i], wide});
  }
  const bool turned = random.Chance(0.5);
  for (const int side : {0, 1}) {
    // One side may be shorter: the flat has the shape of an L.
    const double length = side == 1 && random.Chance(0.4)
                              ? random.Uniform(0.75, 0.95) * plan.length_m
                              : plan.length_m;
    AddRow(Fill((side == 1) != turned, deep[side], length, rows[side]), PassageOf(need), random,
           &plan);
  }
  return Inhabit(plan, need, 2, random);
}

namespace {

// Cells, meeting rooms and open-plan offices along a side.
std::vector<RowOfRooms::Wish> OfficeRow(double length_m, double deep_m, double open_plan,
                                        Random& random) {
  std::vector<RowOfRooms::Wish> rooms;
  for (double x = 0; x < length_m - 2;) {
    const bool open = random.Chance(open_plan) && length_m - x > 9;
    const RoomUse use = open                 ? kOpenPlan
                        : random.Chance(0.2) ? kMeeting
                        : random.Chance(0.1) ? kStore
                                             : kCell;
    const double wide = open              ? random.Uniform(8, std::max(9.0, 2 * deep_m))
                        : use == kMeeting ? random.Uniform(3.6, 6)
                                          : random.Uniform(2.6, 4.6);
    rooms.push_back({use, wide});
    x += wide;
  }
  return rooms;
}

}  // namespace

Scene MakeOffice(const Need& need, Random& random) {
  Plan plan = EmptyPlan(need, random.Uniform(1.6, 2.4), random.Uniform(2.5, 3.2));
  const double area = 200 * std::pow(10, random.Unit());  // 200 to 2000 m2.
  const double most = std::clamp(std::sqrt(area) / 3, 5.0, 12.0);
  const double deep[2] = {random.Uniform(4.4, most), random.Uniform(4.4, most)};
  plan.length_m = std::clamp(area / (deep[0] + deep[1] + plan.corridor_m), 14.0, 80.0);
  const double open_plan = random.Uniform(0, 0.6);
  for (const int side : {0, 1}) {
    AddRow(Fill(side == 1, deep[side], plan.length_m,
                OfficeRow(plan.length_m, deep[side], open_plan, random)),
           PassageOf(need), random, &plan);
  }
  return Inhabit(plan, need, 6, random);
}

Scene MakeStorey(const Need& need, Random& random) {
  Plan plan = EmptyPlan(need, random.Uniform(2, 2.8), random.Uniform(2.7, 3.4));
  plan.storeys = 2 + random.Index(2);
  plan.length_m = random.Uniform(36, 44);
  const double across = random.Uniform(18, 22) - plan.corridor_m, share = random.Uniform(0.4, 0.6);
  const double deep[2] = {share * across, (1 - share) * across};
  for (const int side : {0, 1}) {
    auto rooms = OfficeRow(plan.length_m, deep[side], random.Uniform(0, 0.4), random);
    for (auto& room : rooms) {
      if (room.use == kStore && random.Chance(0.5)) room.use = kLiving;
    }
    if (side == 0) {
      const int at = random.Index(static_cast<int>(rooms.size()) + 1);
      rooms.insert(rooms.begin() + at, {kStairs, 0});
    }
    RowOfRooms row = Fill(side == 1, deep[side], plan.length_m, rooms);
    for (auto& room : row.rooms) {
      if (room.use == kStairs) room.width_m = 2 * plan.flight_m + 0.2;
    }
    AddRow(row, PassageOf(need), random, &plan);
  }
  return Inhabit(plan, need, 6, random);
}

}  // namespace isthmus::simulation::wild
