#include "lab/simulation/worlds/builders.h"
#include "lab/simulation/worlds/floor_plan.h"

namespace isthmus::simulation {
namespace {

// Streams of random numbers of one world, so that more furniture does not move the walls.
enum Stream : uint64_t { kPlan = 1, kFurniture };

Room MakeRoom(double x0, double y0, double x1, double y1, double ceiling_m) {
  Room room;
  room.min = {x0, y0};
  room.max = {x1, y1};
  room.ceiling_m = ceiling_m;
  return room;
}

Wall Line(double x0, double y0, double x1, double y1) { return {{x0, y0}, {x1, y1}}; }

// The four walls of a room.
void AddWalls(const Room& room, FloorPlan& plan) {
  plan.walls.push_back(Line(room.min.x(), room.min.y(), room.max.x(), room.min.y()));
  plan.walls.push_back(Line(room.min.x(), room.max.y(), room.max.x(), room.max.y()));
  plan.walls.push_back(Line(room.min.x(), room.min.y(), room.min.x(), room.max.y()));
  plan.walls.push_back(Line(room.max.x(), room.min.y(), room.max.x(), room.max.y()));
}

// Furnishes a room and, the same way, its twin `apart` from it.
void FurnishTwins(const Room& room, const Eigen::Vector2d& apart, uint64_t seed, World& world) {
  World furniture;
  furniture.roads = world.roads;
  Random random(seed, kFurniture, 0);
  Furnisher furnisher(furniture, random);
  furnisher.FurnishMiddle(room);
  furnisher.FurnishWalls(room);
  world.mesh.Append(furniture.mesh, Eigen::Vector3d::Zero());
  world.mesh.Append(furniture.mesh, {apart.x(), apart.y(), 0});
}

}  // namespace

World MakeMuseum(uint64_t seed) {
  World world;
  Random plan_random(seed, kPlan, 0);
  Random furniture_random(seed, kFurniture, 0);
  const FloorPlan plan = MakeFloorPlan({60, 40}, plan_random);
  BuildFloorPlan(plan, world);
  AddRoads(plan, world.roads);
  Furnisher furnisher(world, furniture_random);
  for (const Room& room : plan.rooms) {
    furnisher.FurnishMiddle(room);
    furnisher.FurnishWalls(room);
    world.furniture.floors.push_back({room.min, room.max});
  }
  return world;
}

World MakeCorridor(uint64_t seed) {
  World world;
  Random furniture_random(seed, kFurniture, 0);
  FloorPlan plan;
  plan.rooms = {MakeRoom(0, 0, 10, 9, 3.2), MakeRoom(10, 3, 80, 6, 3.2),
                MakeRoom(80, -1, 90, 9, 3.2)};
  // The corridor's ends are the lobbies' walls.
  plan.walls = {Line(0, 0, 10, 0),  Line(0, 9, 10, 9),  Line(0, 0, 0, 9),    Line(10, 0, 10, 9),
                Line(10, 3, 80, 3), Line(10, 6, 80, 6), Line(80, -1, 80, 9), Line(80, -1, 90, -1),
                Line(80, 9, 90, 9), Line(90, -1, 90, 9)};
  plan.doors = {{0, 1, {10, 4.5}, {1, 0}, 2.7, 3.0}, {1, 2, {80, 4.5}, {1, 0}, 2.7, 3.0}};
  BuildFloorPlan(plan, world);
  // The corridor is one straight stretch, not a ring.
  FloorPlan lobbies = plan;
  lobbies.rooms.erase(lobbies.rooms.begin() + 1);
  lobbies.doors.clear();
  AddRoads(lobbies, world.roads);
  RoadMap& roads = world.roads;
  const int west = roads.AddNode({8.5, 4.5}, false), east = roads.AddNode({81.5, 4.5}, false);
  roads.Link(west, east);
  // Both lobbies are entered from the two corners of the ring on the corridor's side.
  const auto join = [&roads](int place, int node, double x) {
    for (const int corner : roads.places[place]) {
      if (std::abs(roads.nodes[corner].x() - x) < 3.5) roads.Link(corner, node);
    }
  };
  join(0, west, 8.5);
  join(1, east, 81.5);
  world.fixed_tours = {{0, 1}, {1, 0}};
  world.max_speed_mps = 1.5;
  Furnisher furnisher(world, furniture_random);
  for (const int lobby : {0, 2}) {
    furnisher.FurnishMiddle(plan.rooms[lobby]);
    furnisher.FurnishWalls(plan.rooms[lobby]);
  }
  return world;
}

World MakeTwins(uint64_t seed, bool joined) {
  World world;
  FloorPlan plan;
  // The rooms' north walls have a door each to the hall, at the same place of either room.
  const Room left = MakeRoom(0, 0, 12, 10, 4.2), right = MakeRoom(34, 0, 46, 10, 4.2);
  const Room hall = MakeRoom(0, 10, 46, 19, 4.6);
  plan.rooms = {left, right};
  AddWalls(left, plan);
  AddWalls(right, plan);
  if (joined) {
    plan.rooms.push_back(hall);
    plan.walls.push_back(Line(12, 10, 34, 10));
    plan.walls.push_back(Line(0, 19, 46, 19));
    plan.walls.push_back(Line(0, 10, 0, 19));
    plan.walls.push_back(Line(46, 10, 46, 19));
    plan.doors = {{0, 2, {7, 10}, {0, 1}, 1.9, 2.4}, {1, 2, {41, 10}, {0, 1}, 1.9, 2.4}};
  }
  BuildFloorPlan(plan, world);
  AddRoads(plan, world.roads);

  FurnishTwins(left, right.min - left.min, seed, world);
  if (joined) {
    Random hall_random(seed, kFurniture, 1);
    Furnisher furnisher(world, hall_random);
    furnisher.FurnishMiddle(hall);
    furnisher.FurnishWalls(hall);
  }
  world.fixed_tours = joined ? std::vector<std::vector<int>>{{0, 2}, {1, 2}}
                             : std::vector<std::vector<int>>{{0}, {1}};
  return world;
}

World MakeLargeTwins(uint64_t seed, bool with_wings) {
  World world;
  FloorPlan plan;
  const Room left = MakeRoom(0, 0, 30, 22, 4.8), right = MakeRoom(60, 0, 90, 22, 4.8);
  const Room narrow = MakeRoom(0, 22, 14, 36, 4.2), wide = MakeRoom(60, 22, 86, 31, 4.2);
  plan.rooms = {left, right};
  AddWalls(left, plan);
  AddWalls(right, plan);
  if (with_wings) {
    for (const Room& wing : {narrow, wide}) {  // Their south walls are the halls'.
      const Eigen::Vector2d &min = wing.min, &max = wing.max;
      plan.rooms.push_back(wing);
      plan.walls.push_back(Line(min.x(), max.y(), max.x(), max.y()));
      plan.walls.push_back(Line(min.x(), min.y(), min.x(), max.y()));
      plan.walls.push_back(Line(max.x(), min.y(), max.x(), max.y()));
    }
    plan.doors = {{0, 2, {7, 22}, {0, 1}, 1.9, 2.4}, {1, 3, {67, 22}, {0, 1}, 1.9, 2.4}};
  }
  BuildFloorPlan(plan, world);
  AddRoads(plan, world.roads);
  FurnishTwins(left, right.min - left.min, seed, world);
  world.fixed_tours = {{0}, {1}};
  if (with_wings) {
    Random wing_random(seed, kFurniture, 1);
    Furnisher furnisher(world, wing_random);
    for (const Room& wing : {narrow, wide}) {
      furnisher.FurnishMiddle(wing);
      furnisher.FurnishWalls(wing);
    }
    world.fixed_tours = {{0, 2}, {1, 3}};
  }
  return world;
}

}  // namespace isthmus::simulation
