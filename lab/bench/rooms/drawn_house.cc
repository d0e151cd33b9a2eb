#include "lab/bench/rooms/drawn_house.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "lab/bench/rooms/canvas.h"
#include "lab/simulation/wild/furnish.h"
#include "lab/simulation/wild/path.h"
#include "lab/simulation/wild/plan.h"

namespace isthmus::bench {
namespace {

namespace wild = simulation::wild;
using simulation::Random;
using wild::RoomUse;

constexpr double kBaseM = 0.5, kClearM = kBaseM / 2 + 0.3;  // A robot's.

// Rooms beside each other along a side.
wild::RowOfRooms Row(bool north, bool is_flat, double length_m, Random& random) {
  constexpr std::array kFlat = {RoomUse::kLiving, RoomUse::kBed, RoomUse::kKitchen, RoomUse::kBed};
  constexpr std::array kOffice = {RoomUse::kCell, RoomUse::kCell, RoomUse::kMeeting,
                                  RoomUse::kStore, RoomUse::kOpenPlan};
  wild::RowOfRooms row{north, is_flat ? random.Uniform(2.8, 5.2) : random.Uniform(4.4, 8), {}};
  double sum = 0;
  while (sum < length_m - 2) {
    const RoomUse use = is_flat ? kFlat[static_cast<size_t>(random.Index(4))]
                                : kOffice[static_cast<size_t>(random.Index(5))];
    const double wide =
        use == RoomUse::kOpenPlan ? random.Uniform(8, 12) : random.Uniform(2.6, 4.6);
    row.rooms.push_back({use, wide});
    sum += wide;
  }
  for (auto& room : row.rooms) room.width_m *= length_m / sum;
  return row;
}

wild::Plan Design(Random& random) {
  wild::Plan plan;
  const bool is_flat = random.Chance(0.5);
  plan.corridor_m = is_flat ? random.Uniform(1.3, 1.7) : random.Uniform(1.6, 2.4);
  plan.storey_m = 3;
  plan.door_high_m = 2.05;
  plan.length_m = is_flat ? random.Uniform(6, 12) : random.Uniform(14, 40);
  const double length_m = plan.length_m;
  for (const bool north : {false, true}) {
    wild::AddRow(Row(north, is_flat, length_m, random), {kBaseM, 0.8}, random, &plan);
  }
  return plan;
}

floors::GridMap Draw(const simulation::Mesh& mesh, const wild::Plan& plan, const Canvas& canvas) {
  floors::GridMap map = canvas.map();
  for (const auto& triangle : mesh.triangles) {
    std::array<Eigen::Vector3d, 3> corners;
    for (size_t i = 0; i < 3; ++i) corners[i] = mesh.vertices[triangle[i]].cast<double>();
    canvas.Occupy(corners, &map);
  }
  // Nothing stands in the corridor's middle.
  FreeFrom(canvas.CellAt({plan.rooms.front().door_x, 0}), &map);
  return map;
}

TrueRooms TruthOf(const wild::Plan& plan, const Canvas& canvas) {
  TrueRooms truth;
  for (int64_t y = 0; y < canvas.map().height; ++y) {
    for (int64_t x = 0; x < canvas.map().width; ++x) {
      const Eigen::Vector2d at = canvas.InPlan(x, y);
      int32_t& label = truth.labels.emplace_back(-1);
      if (std::abs(at.y()) < plan.corridor_m / 2 && at.x() > 0 && at.x() < plan.length_m) label = 0;
      for (size_t i = 0; i < plan.rooms.size() && label < 0; ++i) {
        const wild::PlannedRoom& room = plan.rooms[i];
        const bool inside =
            (at.array() >= room.min.array()).all() && (at.array() < room.max.array()).all();
        if (inside) label = static_cast<int32_t>(i) + 1;
      }
    }
  }
  for (const wild::PlannedRoom& room : plan.rooms) {
    truth.doors.push_back(canvas.InMap(room.Behind(room.door_x, 0)));
  }
  return truth;
}

}  // namespace

DrawnHouse DrawHouse(uint64_t seed) {
  Random random(seed);
  const wild::Plan plan = Design(random);
  const Canvas canvas(plan, random.Uniform(0, std::numbers::pi / 2));
  simulation::Mesh mesh;
  wild::AddPlanTo(plan, random, &mesh);
  DrawnHouse house{Draw(mesh, plan, canvas), {}, TruthOf(plan, canvas)};
  const auto way = std::make_shared<const wild::Path>(wild::Path::Along(
      wild::StrollThrough(plan, {0.6, plan.length_m - 0.6, 5 * plan.length_m}, random), 0.4));
  wild::FurnishPlan(plan, {.world = seed, .day = seed}, kClearM, wild::Trodden({way}), &mesh);
  house.furnished = Draw(mesh, plan, canvas);
  return house;
}

}  // namespace isthmus::bench
