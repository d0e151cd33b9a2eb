#include <algorithm>
#include <cmath>
#include <vector>

#include "lab/simulation/wild/plan.h"
#include "lab/simulation/wild/shapes.h"

namespace isthmus::simulation::wild {
namespace {

constexpr double kInnerM = 0.12, kOuterM = 0.3;  // Walls.

void AddFloor(const Eigen::Vector2d& min, const Eigen::Vector2d& max, double z, double thick_m,
              PointClass top, Mesh* mesh) {
  const Eigen::Vector2d middle = (min + max) / 2, size = max - min;
  As(mesh, PointClass::kWall)
      ->AddSlab({middle.x(), middle.y(), z - thick_m}, {size.x(), size.y(), thick_m}, 0,
                Material::kFloor, top);
}

// Slabs over and below: not where stairs come up.
void AddSlabs(const Plan& plan, int level, Mesh* mesh) {
  const double z = level * plan.storey_m;
  const PointClass top = level == plan.storeys ? PointClass::kCeiling : PointClass::kGround;
  AddFloor({0, -plan.corridor_m / 2}, {plan.length_m, plan.corridor_m / 2}, z, plan.slab_m, top,
           mesh);
  for (const PlannedRoom& room : plan.rooms) {
    Eigen::Vector2d min = room.min, max = room.max;
    if (room.use == RoomUse::kStairs && level > 0 && level < plan.storeys) {
      (room.north ? max : min).y() = room.Behind(0, plan.landing_m()).y();
    }
    AddFloor(min, max, z, plan.slab_m, top, mesh);
  }
}

void AddFlights(const Plan& plan, const PlannedRoom& stairs, int storey, Mesh* mesh) {
  const double z = storey * plan.storey_m, half = plan.storey_m / 2, landing = plan.landing_m();
  const double run = plan.run_m(stairs);
  const As step(mesh, PointClass::kGround);
  const int steps = std::max(2, static_cast<int>(std::lround(half / 0.17)));
  for (const bool second : {false, true}) {
    const double x = stairs.door_x + (second ? 0.5 : -0.5) * plan.flight_m;
    for (int i = 0; i < steps; ++i) {
      const double along = (i + 0.5) * run / steps;
      const Eigen::Vector2d at = stairs.Behind(x, landing + (second ? run - along : along));
      const double low = z + (second ? half : 0) + i * half / steps;
      mesh->AddSlab({at.x(), at.y(), low}, {plan.flight_m, run / steps, half / steps}, 0,
                    Material::kStone, PointClass::kGround);
    }
  }
  const Eigen::Vector2d a = stairs.Behind(stairs.min.x(), landing + run);
  const Eigen::Vector2d b = stairs.Behind(stairs.max.x(), stairs.Size().y());
  AddFloor(a.cwiseMin(b), a.cwiseMax(b), z + half, 0.2, PointClass::kGround, mesh);
}

std::vector<Opening> Windows(double length, double high, Random& random) {
  std::vector<Opening> openings;
  const double sill = random.Chance(0.2) ? 0.1 : random.Uniform(0.7, 1.0);
  for (double at = random.Uniform(0.4, 1.2); at + 1.2 < length; at += random.Uniform(1.8, 3.5)) {
    const double to = std::min(at + random.Uniform(0.7, 1.6), length - 0.3);
    openings.push_back({at, to, sill, high - 0.25, true});
    at = to;
  }
  return openings;
}

// All storeys' walls are alike.
void AddRoomWalls(const Plan& plan, const PlannedRoom& room, double z,
                  const std::vector<Opening>& windows, Mesh* mesh) {
  const double high = plan.clear_height(), deep = room.Size().y();
  const auto at = [&](double x, double into) {
    const Eigen::Vector2d p = room.Behind(x, into);
    return Eigen::Vector3d(p.x(), p.y(), z);
  };
  const double door = room.door_x - room.min.x();
  AddWallWithOpenings(
      at(room.min.x(), 0), at(room.max.x(), 0), high, kInnerM,
      {{door - plan.door_m / 2, door + plan.door_m / 2, 0, plan.door_high_m, false}},
      Material::kPlaster, mesh);
  AddWallWithOpenings(at(room.min.x(), deep), at(room.max.x(), deep), high, kOuterM,
                      room.use == RoomUse::kStairs ? std::vector<Opening>{} : windows,
                      Material::kPlaster, mesh);
  for (const double x : {room.min.x(), room.max.x()}) {
    const bool outer = x == 0 || x == plan.length_m;
    AddWall(at(x, 0), at(x, deep), high, outer ? kOuterM : kInnerM, Material::kPlaster, mesh);
  }
}

// The ends of the corridor, and its sides where no room is.
void AddCorridorWalls(const Plan& plan, double z, const std::vector<Opening>& windows, Mesh* mesh) {
  const double high = plan.clear_height(), y = plan.corridor_m / 2;
  for (const double x : {0.0, plan.length_m}) {
    AddWall({x, -y, z}, {x, y, z}, high, kOuterM, Material::kPlaster, mesh);
  }
  for (const bool north : {false, true}) {
    double end = 0;
    for (const PlannedRoom& room : plan.rooms) {
      if (room.north == north) end = std::max(end, room.max.x());
    }
    if (end > plan.length_m - 0.01) continue;
    std::vector<Opening> here;
    for (const Opening& window : windows) {
      if (window.to_m + 0.3 < plan.length_m - end) here.push_back(window);
    }
    AddWallWithOpenings({end, north ? y : -y, z}, {plan.length_m, north ? y : -y, z}, high, kOuterM,
                        here, Material::kPlaster, mesh);
  }
}

}  // namespace

void AddPlanTo(const Plan& plan, Random& random, Mesh* mesh) {
  std::vector<std::vector<Opening>> windows;
  for (const PlannedRoom& room : plan.rooms) {
    windows.push_back(Windows(room.Size().x(), plan.clear_height(), random));
  }
  const auto along = Windows(plan.length_m, plan.clear_height(), random);
  for (int level = 0; level <= plan.storeys; ++level) {
    AddSlabs(plan, level, mesh);
    if (level == plan.storeys) break;
    const double z = level * plan.storey_m;
    AddCorridorWalls(plan, z, along, mesh);
    for (size_t i = 0; i < plan.rooms.size(); ++i) {
      AddRoomWalls(plan, plan.rooms[i], z, windows[i], mesh);
    }
    const PlannedRoom* stairs = plan.stairs();
    if (stairs != nullptr && level + 1 < plan.storeys) AddFlights(plan, *stairs, level, mesh);
  }
}

}  // namespace isthmus::simulation::wild
