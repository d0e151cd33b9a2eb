#include "lab/simulation/wild/furnish.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lab/simulation/wild/shapes.h"

namespace isthmus::simulation::wild {
namespace {

// A room to be filled, and the streams of its things: however many of them find a place, the next
// one is the same.
class RoomFiller {
 public:
  RoomFiller(const Season& season, uint64_t first, Floor* floor, Mesh* mesh)
      : season_(season),
        built_in_(season.world, 0x97, first),
        next_(first),
        floor_(*floor),
        mesh_(mesh) {}

  Random Next() { return season_.Draw(next_++); }

  void Shelves(int count) {
    for (int i = 0; i < count; ++i) {
      Random thing = Next();
      const Eigen::Vector3d size{thing.Uniform(0.5, 1.3), thing.Uniform(0.25, 0.42),
                                 thing.Uniform(0.7, 2.2)};
      const auto spot = floor_.TakeAtWall(size.head<2>(), Gap(thing), thing);
      if (spot) AddShelf(*spot, size, thing, mesh_);
    }
  }
  // Wardrobes, drawers, machines.
  void Cupboards(int count) {
    for (int i = 0; i < count; ++i) {
      Random thing = Next();
      const Eigen::Vector3d size{thing.Uniform(0.5, 2), thing.Uniform(0.4, 0.62),
                                 thing.Uniform(0.6, 2.1)};
      const auto spot = floor_.TakeAtWall(size.head<2>(), Gap(thing), thing);
      if (!spot) continue;
      const As cupboard(mesh_, PointClass::kObject);
      mesh_->AddBox(spot->foot, size, spot->yaw, Material::kWood);
      for (int k = thing.Index(3); k > 0 && size.z() < 1.4; --k) {  // On top.
        const Spot thing_on = spot->Beside(thing.Uniform(-0.35, 0.35) * size.x(), 0, thing.Unit());
        mesh_->AddBox(thing_on.At(0, 0, size.z()), {0.25, 0.2, thing.Uniform(0.1, 0.4)},
                      thing_on.yaw, Material::kPlaster);
      }
    }
  }
  void Sofas(int count) {
    for (int i = 0; i < count; ++i) {
      Random thing = Next();
      const bool wide = i == 0;
      const Eigen::Vector3d size{wide ? thing.Uniform(1.5, 2.4) : thing.Uniform(0.75, 0.95),
                                 thing.Uniform(0.75, 0.95), thing.Uniform(0.7, 0.9)};
      const auto spot = wide ? floor_.TakeAtWall(size.head<2>(), Gap(thing), thing)
                             : floor_.TakeAnywhere(size.head<2>(), thing);
      if (spot) AddSofa(*spot, size, thing, mesh_);
    }
  }
  void Beds(int count) {
    for (int i = 0; i < count; ++i) {
      Random thing = Next();
      const Eigen::Vector3d size{thing.Chance(0.5) ? 0.95 : thing.Uniform(1.4, 1.8), 2.05,
                                 thing.Uniform(0.4, 0.6)};
      // The long side or the head at the wall.
      const bool along = thing.Chance(0.5);
      const Eigen::Vector2d at_wall =
          along ? Eigen::Vector2d(size.y(), size.x()) : Eigen::Vector2d(size.head<2>());
      auto spot = floor_.TakeAtWall(at_wall, Gap(thing), thing);
      if (!spot) continue;
      if (along) spot->yaw += thing.Chance(0.5) ? std::numbers::pi / 2 : -std::numbers::pi / 2;
      AddBed(*spot, size, thing, mesh_);
    }
  }
  // A table and the chairs around it, drawn up or pushed back.
  void TableWithChairs(double longest_m, bool at_wall) {
    constexpr double kAround = 0.38;
    Random thing = Next();
    const Eigen::Vector3d size{thing.Uniform(0.7, longest_m), thing.Uniform(0.65, 1.0),
                               thing.Uniform(0.7, 0.77)};
    const Eigen::Vector2d all = size.head<2>().array() + 2 * kAround;
    auto spot = at_wall ? std::nullopt : floor_.TakeAnywhere(all, thing);
    if (!spot) spot = floor_.TakeAtWall(all, 0.03, thing);
    if (!spot) return;
    AddTable(*spot, size, mesh_);
    for (double x = -size.x() / 2 + 0.35; x < size.x() / 2 - 0.2; x += 0.65) {
      for (const double side : {-1.0, 1.0}) {
        const double out = size.y() / 2 + thing.Uniform(-0.05, 0.12),
                     turned = thing.Uniform(-0.6, 0.6);
        const double off = thing.Uniform(-0.08, 0.08);
        if (thing.Chance(0.2)) continue;
        AddChair(spot->Beside(x + off, side * out, (side > 0 ? std::numbers::pi : 0) + turned),
                 thing, mesh_);
      }
    }
  }
  // A desk and the chair before it.
  void Desk(const std::optional<Spot>& spot, const Eigen::Vector3d& size, Random& thing) {
    if (!spot) return;
    AddDesk(spot->Beside(0, -kSeatM / 2, 0), size, thing, mesh_);
    const double x = thing.Uniform(-0.35, 0.35), y = size.y() / 2 + thing.Uniform(-0.4, 0.05);
    if (thing.Chance(0.9)) {
      AddSwivelChair(spot->Beside(x, y, std::numbers::pi + thing.Uniform(-1.2, 1.2)), thing, mesh_);
    }
  }
  void Desks(int count) {
    for (int i = 0; i < count; ++i) {
      Random thing = Next();
      const Eigen::Vector3d size = DeskSize(thing);
      Desk(floor_.TakeAtWall({size.x(), size.y() + kSeatM}, Gap(thing), thing), size, thing);
    }
  }
  // Desks back to back, where nobody walks; rows are as wide as chairs need.
  void DeskRows() {
    const double half = (0.8 + kSeatM) / 2;
    for (double y = half + 0.3; y + 3 * half < floor_.Size().y(); y += 4 * half + 0.4) {
      Random row = Next();
      const double shift = row.Uniform(0, 0.8), wide = row.Uniform(1.3, 1.7);
      for (double x = 0.1 + shift; x + wide < floor_.Size().x(); x += wide + 0.02) {
        for (const bool facing : {false, true}) {
          Random thing = Next();
          const Eigen::Vector3d at(floor_.min().x() + x + wide / 2,
                                   floor_.min().y() + y + (facing ? 2 * half : 0), floor_.z());
          const Spot spot{at, facing ? 0 : std::numbers::pi};
          const Eigen::Vector3d size(wide, 0.8, 0.74);
          if (thing.Chance(0.88) && floor_.Take(spot, {wide, 2 * half})) Desk(spot, size, thing);
        }
      }
    }
  }
  void Plants(int count) {
    for (int i = 0; i < count; ++i) {
      Random thing = Next();
      const auto spot = thing.Chance(0.5) ? floor_.TakeAtWall({0.5, 0.5}, Gap(thing), thing)
                                          : floor_.TakeAnywhere({0.5, 0.5}, thing);
      if (spot && thing.Chance(0.6)) AddPlantPot(*spot, thing.Uniform(0.5, 1.7), thing, mesh_);
    }
  }
  // Things that stand about: cartons, chairs, lamps, bins.
  void Clutter(int count) {
    for (int i = 0; i < count; ++i) {
      Random thing = Next();
      const double side = thing.Uniform(0.25, 0.55), kind = thing.Unit();
      const Eigen::Vector2d size =
          kind < 0.5 ? Eigen::Vector2d(side, side) * 1.2 : Eigen::Vector2d(0.55, 0.55);
      const auto spot = thing.Chance(0.6) ? floor_.TakeAtWall(size, Gap(thing), thing)
                                          : floor_.TakeAnywhere(size, thing);
      if (!spot || thing.Chance(0.3)) continue;
      if (kind < 0.5) {
        AddCartons({spot->foot, spot->yaw + thing.Uniform(-0.2, 0.2)}, side, thing, mesh_);
      } else if (kind < 0.75) {
        AddChair({spot->foot, thing.Uniform(0, 2 * std::numbers::pi)}, thing, mesh_);
      } else if (kind < 0.88) {
        AddLamp(*spot, thing.Uniform(1.2, 1.8), mesh_);
      } else {
        As(mesh_, PointClass::kObject)
            ->AddCylinder(spot->foot, thing.Uniform(0.12, 0.22), thing.Uniform(0.3, 0.7),
                          Material::kPlaster);
      }
    }
  }
  void Kitchen() {
    const double wide = std::min(built_in_.Uniform(2.2, 3.6), floor_.Size().maxCoeff() - 0.2);
    const auto spot = floor_.TakeAtWall({wide, 0.62}, 0.01, built_in_);
    if (spot) AddKitchenLine(*spot, wide, built_in_, mesh_);
  }
  void Bath() {
    for (const auto& [size, high] :
         {std::pair(Eigen::Vector2d(1.65, 0.72), 0.55), {{0.9, 0.5}, 0.85}, {{0.4, 0.65}, 0.45}}) {
      const auto spot = floor_.TakeAtWall(size, 0.01, built_in_);
      if (!spot) continue;
      As(mesh_, PointClass::kObject)
          ->AddBox(spot->foot, {size.x(), size.y(), high}, spot->yaw, Material::kPlaster);
    }
  }
  void Columns() {
    constexpr double kEvery = 6.3;
    for (double x = kEvery / 2; x < floor_.Size().x(); x += kEvery) {
      for (double y = kEvery / 2; y < floor_.Size().y(); y += kEvery) {
        const Spot spot{{floor_.min().x() + x, floor_.min().y() + y, floor_.z()}, 0};
        if (floor_.Take(spot, {0.4, 0.4})) {
          As(mesh_, PointClass::kPole)->AddBox(spot.foot, {0.4, 0.4, 2.4}, 0, Material::kStone);
        }
      }
    }
  }

 private:
  static constexpr double kSeatM = 0.8;  // Before a desk, for its chair.

  static double Gap(Random& random) { return random.Uniform(0.01, 0.08); }
  static Eigen::Vector3d DeskSize(Random& random) {
    const double wide = random.Uniform(1.1, 1.8), deep = random.Uniform(0.6, 0.85);
    return {wide, deep, random.Uniform(0.7, 0.78)};
  }

  const Season& season_;
  Random built_in_;
  uint64_t next_;
  Floor& floor_;
  Mesh* mesh_;
};

}  // namespace

void Furnish(RoomUse use, const Season& season, uint64_t first, Floor* floor, Mesh* mesh) {
  RoomFiller room(season, first, floor, mesh);
  const double area = floor->Size().prod();
  const auto every = [area](double m2) { return std::max(1, static_cast<int>(area / m2)); };
  switch (use) {
    case RoomUse::kLiving:
      room.Sofas(1), room.TableWithChairs(1.8, false), room.Sofas(2), room.Shelves(every(6));
      room.Cupboards(2), room.Plants(4), room.Clutter(every(1.5));
      return;
    case RoomUse::kBed:
      room.Beds(every(12)), room.Cupboards(2), room.Desks(1), room.Shelves(2), room.Cupboards(2);
      room.Plants(2), room.Clutter(every(1.5));
      return;
    case RoomUse::kKitchen:
      room.Kitchen(), room.TableWithChairs(1.4, false), room.Shelves(2), room.Cupboards(2);
      room.Plants(1), room.Clutter(every(1.5));
      return;
    case RoomUse::kBath:
      room.Bath(), room.Cupboards(1), room.Clutter(4);
      return;
    case RoomUse::kCell:
      room.Desks(every(8)), room.Shelves(every(9)), room.Cupboards(1), room.Plants(1);
      room.Clutter(every(6));
      return;
    case RoomUse::kOpenPlan:
      room.Columns(), room.DeskRows(), room.Desks(every(15)), room.Shelves(every(20)),
          room.Cupboards(every(25));
      room.Plants(every(18)), room.Clutter(every(9));
      return;
    case RoomUse::kMeeting:
      room.TableWithChairs(std::clamp(floor->Size().maxCoeff() - 2.5, 1.4, 4.0), false);
      room.Cupboards(1), room.Plants(2), room.Clutter(every(7));
      return;
    case RoomUse::kStore:
      room.Shelves(every(3)), room.Clutter(every(2));
      return;
    case RoomUse::kStairs:
      return;
  }
}

void FurnishPlan(const Plan& plan, const Season& season, double clear_m,
                 const std::vector<Eigen::Vector3d>& trodden, Mesh* mesh) {
  constexpr double kFromWallM = 0.16;
  constexpr uint64_t kMost = 1000;  // Things in a room.
  uint64_t number = 1;
  for (int storey = 0; storey < plan.storeys; ++storey) {
    const double z = storey * plan.storey_m;
    // Doors and the corridor are ways, whoever takes them.
    std::vector<Eigen::Vector3d> ways = trodden;
    for (const PlannedRoom& room : plan.rooms) {
      for (const double into : {-0.6, -0.3, 0.0, 0.4, 0.8}) {
        const Eigen::Vector2d at = room.Behind(room.door_x, into);
        ways.push_back({at.x(), at.y(), z});
      }
    }
    for (double x = 0; x < plan.length_m; x += 0.3) ways.push_back({x, 0, z});
    for (const PlannedRoom& room : plan.rooms) {
      Floor floor(room.min.array() + kFromWallM, room.max.array() - kFromWallM, z, clear_m, ways);
      Furnish(room.use, season, kMost * number++, &floor, mesh);
    }
    const double wide = plan.corridor_m / 2 - 0.07;
    Floor corridor({kFromWallM, -wide}, {plan.length_m - kFromWallM, wide}, z, clear_m, ways);
    RoomFiller along(season, kMost * number++, &corridor, mesh);
    along.Cupboards(static_cast<int>(plan.length_m / 8));
    along.Plants(static_cast<int>(plan.length_m / 8));
    along.Clutter(static_cast<int>(plan.length_m / 3));
  }
}

}  // namespace isthmus::simulation::wild
