#include "lab/simulation/worlds/floor_plan.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace isthmus::simulation {
namespace {

constexpr double kMinSide = 7.5;

// Splits across the longer side until rooms are small enough (binary space partition).
void Split(const Room& room, Random& random, FloorPlan& plan) {
  const Eigen::Vector2d size = room.Size();
  const int axis = size.x() > size.y() ? 0 : 1;
  if (size[axis] < 2 * kMinSide || (size[axis] < 20 && random.Chance(0.7))) {
    plan.rooms.push_back(room);
    plan.rooms.back().ceiling_m = random.Uniform(4.0, 5.0);
    plan.rooms.back().ring_inset_m = random.Uniform(1.9, 2.5);
    return;
  }
  const double at =
      std::clamp(random.Uniform(0.35, 0.65) * size[axis], kMinSide, size[axis] - kMinSide);
  Room low = room, high = room;
  low.max[axis] = high.min[axis] = room.min[axis] + at;
  plan.walls.push_back({high.min, low.max});
  Split(low, random, plan);
  Split(high, random, plan);
}

// The doorway between two rooms that share enough wall, b on the positive side of a.
bool FindDoor(const FloorPlan& plan, int a, int b, Random& random, Door& door) {
  const Room& low = plan.rooms[a];
  const Room& high = plan.rooms[b];
  for (int axis = 0; axis < 2; ++axis) {
    const int along = 1 - axis;
    if (std::abs(low.max[axis] - high.min[axis]) > 1e-9) continue;
    const double from = std::max(low.min[along], high.min[along]);
    const double to = std::min(low.max[along], high.max[along]);
    if (to - from < 4.5) continue;
    door.a = a;
    door.b = b;
    door.width_m = to - from > 8 && random.Chance(0.3) ? 3.4 : random.Uniform(1.7, 2.4);
    door.height_m = door.width_m > 3 ? 3.2 : random.Uniform(2.2, 2.7);
    const double margin = door.width_m / 2 + 0.8;
    door.center[axis] = low.max[axis];
    door.center[along] = random.Uniform(from + margin, to - margin);
    door.across = Eigen::Vector2d::Unit(axis);
    return true;
  }
  return false;
}

// A spanning tree of doors, and some more.
void ChooseDoors(Random& random, FloorPlan& plan) {
  const int count = static_cast<int>(plan.rooms.size());
  std::vector<Door> possible;
  for (int a = 0; a < count; ++a) {
    for (int b = 0; b < count; ++b) {
      Door door;
      if (a != b && FindDoor(plan, a, b, random, door)) possible.push_back(door);
    }
  }
  for (size_t i = possible.size(); i > 1; --i) {
    std::swap(possible[i - 1], possible[random.Index(static_cast<int>(i))]);
  }
  std::vector<int> group(count);
  std::iota(group.begin(), group.end(), 0);
  for (const Door& door : possible) {
    const int from = group[door.b], to = group[door.a];
    if (from == to && !random.Chance(0.5)) continue;
    for (int& g : group) g = g == from ? to : g;
    plan.doors.push_back(door);
  }
}

void BuildWall(const FloorPlan& plan, const Wall& wall, Mesh& mesh) {
  const As as(&mesh, PointClass::kWall);
  const int along = std::abs(wall.to.x() - wall.from.x()) > 1e-9 ? 0 : 1;
  std::vector<Door> doors;
  for (const Door& door : plan.doors) {
    if (std::abs(door.center[1 - along] - wall.from[1 - along]) < 1e-9 &&
        door.center[along] > wall.from[along] && door.center[along] < wall.to[along]) {
      doors.push_back(door);
    }
  }
  std::sort(doors.begin(), doors.end(),
            [&](const Door& a, const Door& b) { return a.center[along] < b.center[along]; });
  const auto piece = [&](double from, double to, double bottom) {
    Eigen::Vector3d base(0, 0, bottom);
    base[along] = (from + to) / 2;
    base[1 - along] = wall.from[1 - along];
    Eigen::Vector3d size(kWallThickness, kWallThickness, kWallHeight - bottom);
    size[along] = to - from;
    mesh.AddBox(base, size, 0, Material::kPlaster);
  };
  double from = wall.from[along] - kWallThickness / 2;
  for (const Door& door : doors) {
    const double left = door.center[along] - door.width_m / 2;
    piece(from, left, 0);
    from = left + door.width_m;
    piece(left, from, door.height_m);
  }
  piece(from, wall.to[along] + kWallThickness / 2, 0);
}

// The closed way along a room's walls.
struct Ring {
  Eigen::Vector2d min, max;
  std::map<double, int> nodes;  // By the distance along the ring, counter-clockwise.

  explicit Ring(const Room& room) {
    const Eigen::Vector2d inset = (0.28 * room.Size()).cwiseMin(room.ring_inset_m);
    min = room.min + inset;
    max = room.max - inset;
  }
  double Along(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d size = max - min, d = p - min;
    if (std::abs(d.y()) < 1e-9) return d.x();
    if (std::abs(d.x() - size.x()) < 1e-9) return size.x() + d.y();
    if (std::abs(d.y() - size.y()) < 1e-9) return 2 * size.x() + size.y() - d.x();
    return 2 * size.sum() - d.y();
  }
  int Node(const Eigen::Vector2d& p, RoadMap& roads) {
    for (const auto& [along, node] : nodes) {
      if ((roads.nodes[node] - p).norm() < 0.5) return node;
    }
    return nodes[Along(p)] = roads.AddNode(p, true);
  }
};

}  // namespace

FloorPlan MakeFloorPlan(const Eigen::Vector2d& size, Random& random) {
  FloorPlan plan;
  Room all;
  all.min.setZero();
  all.max = size;
  const Eigen::Vector2d x(size.x(), 0), y(0, size.y());
  plan.walls = {{all.min, x}, {y, size}, {all.min, y}, {x, size}};
  Split(all, random, plan);
  ChooseDoors(random, plan);
  return plan;
}

void BuildFloorPlan(const FloorPlan& plan, World& world) {
  for (const Wall& wall : plan.walls) BuildWall(plan, wall, world.mesh);
  for (const Room& room : plan.rooms) {
    const auto at = [](double x, double y, double z) { return Eigen::Vector3d(x, y, z); };
    for (const double z : {0.0, room.ceiling_m}) {
      const As as(&world.mesh, z > 0 ? PointClass::kCeiling : PointClass::kGround);
      world.mesh.AddQuad(at(room.min.x(), room.min.y(), z), at(room.max.x(), room.min.y(), z),
                         at(room.max.x(), room.max.y(), z), at(room.min.x(), room.max.y(), z),
                         z > 0 ? Material::kPlaster : Material::kFloor);
    }
  }
}

void AddRoads(const FloorPlan& plan, RoadMap& roads) {
  std::vector<Ring> rings;
  for (const Room& room : plan.rooms) {
    Ring& ring = rings.emplace_back(room);
    ring.Node(ring.min, roads);
    ring.Node({ring.max.x(), ring.min.y()}, roads);
    ring.Node(ring.max, roads);
    ring.Node({ring.min.x(), ring.max.y()}, roads);
  }
  for (const Door& door : plan.doors) {
    int ends[2];
    for (const int side : {0, 1}) {
      const Eigen::Vector2d at = door.center + (side == 0 ? -0.9 : 0.9) * door.across;
      Ring& ring = rings[side == 0 ? door.a : door.b];
      ends[side] = roads.AddNode(at, false);
      roads.Link(ends[side], ring.Node(at.cwiseMax(ring.min).cwiseMin(ring.max), roads));
    }
    roads.Link(ends[0], ends[1]);
  }
  for (const Ring& ring : rings) {
    std::vector<int> cycle;
    for (const auto& [along, node] : ring.nodes) cycle.push_back(node);
    roads.AddPlace(cycle);
  }
}

}  // namespace isthmus::simulation
