// A hotel: a corridor between rooms that are furnished alike, on storeys that are built alike. Only
// loose things tell one room, and one storey, from another. In an inn these are all that is not
// built in.
#include <algorithm>
#include <numbers>

#include "lab/simulation/wild/furnish.h"
#include "lab/simulation/wild/furniture.h"
#include "lab/simulation/wild/scenes.h"
#include "lab/simulation/wild/shapes.h"

namespace isthmus::simulation::wild {
namespace {

constexpr double kWallM = 0.12, kBathM = 2;  // Depth of the bathroom.
constexpr double kHalfTurn = std::numbers::pi;

struct Hotel {
  int units, storeys;  // On either side of the corridor; alike.
  double storey_m, slab_m = 0.3;
  double unit_m, deep_m, corridor_m, door_m, entry_m;
  double window_m;

  double length() const { return units * unit_m; }
  double clear_height() const { return storey_m - slab_m; }
  // A place in a room: along the corridor from its near corner, and into it.
  Eigen::Vector2d In(int unit, bool left, double along_m, double into_m) const {
    const double y = corridor_m / 2 + into_m;
    return {unit * unit_m + along_m, left ? y : -y};
  }
  double door_x() const { return unit_m - entry_m / 2; }
};

Hotel DesignHotel(const Need& need, Random& random) {
  Hotel hotel;
  hotel.units = 4 + random.Index(8);
  hotel.storeys = 2 + random.Index(3);
  hotel.storey_m = std::max(need.clear_height_m() + 0.7, random.Uniform(2.8, 3.6));
  hotel.door_m = std::max(2 * need.clear_m() + 0.1, random.Uniform(0.9, 1.2));
  hotel.entry_m = hotel.door_m + 0.2;
  hotel.unit_m = std::max(hotel.entry_m + 2.2, random.Uniform(3.6, 5.5));
  hotel.deep_m = kBathM + std::max(3.6, random.Uniform(3.4, 5));
  hotel.corridor_m = std::max(2 * need.clear_m() + 0.4, random.Uniform(1.6, 2.6));
  hotel.window_m = random.Uniform(1, 2);
  return hotel;
}

// Up and down the corridor, with a look into some rooms.
std::vector<Eigen::Vector3d> Stroll(const Hotel& hotel, const Need& need, Random& random) {
  std::vector<Eigen::Vector3d> corners;
  double path_length = 0;
  const auto go = [&](const Eigen::Vector2d& to) {
    if (!corners.empty()) path_length += (corners.back().head<2>() - to).norm();
    corners.push_back({to.x(), to.y(), 0});
  };
  const double margin = need.clear_m() + 0.3;
  for (bool up = true; path_length < need.path_length_m + 20; up = !up) {
    go({up ? margin : hotel.length() - margin, 0});
    for (int i = 0; i < hotel.units; ++i) {
      const int unit = up ? i : hotel.units - 1 - i;
      const bool left = random.Chance(0.5);
      if (random.Chance(0.6)) continue;
      const double far = hotel.deep_m - need.clear_m() - 0.4;
      const Eigen::Vector2d door = hotel.In(unit, left, hotel.door_x(), 0);
      go({door.x(), 0});
      go(hotel.In(unit, left, hotel.door_x(), random.Uniform(kBathM, far)));
      go({door.x(), 0});
    }
  }
  return corners;
}

// A guest's room: bed, desk, chair, curtains and luggage stand as they were left, the luggage not
// on trodden places.
void AddOwnFurniture(const Hotel& hotel, int unit, bool left, double z,
                     const std::vector<Eigen::Vector3d>& trodden, Random thing, Mesh* mesh) {
  const auto spot = [&](double along, double into, double turned) {
    const Eigen::Vector2d p = hotel.In(unit, left, along, into);
    return Spot{{p.x(), p.y(), z}, turned};
  };
  const double d = hotel.deep_m;
  const double bed = thing.Uniform(1, 1.15), bed_into = kBathM + thing.Uniform(1.43, 1.5);
  AddBed(spot(bed, bed_into, -kHalfTurn / 2 + thing.Uniform(-0.05, 0.05)), {1.55, 1.9, 0.5}, thing,
         mesh);
  const double outwards = left ? kHalfTurn : 0;
  const Spot desk = spot(thing.Uniform(0.68, 0.8), d - 0.5, outwards + thing.Uniform(-0.04, 0.04));
  AddDesk(desk, {1.15, 0.55, 0.75}, thing, mesh);
  const double x = thing.Uniform(-0.2, 0.2), y = thing.Uniform(0.3, 0.6);
  AddChair(desk.Beside(x, y, kHalfTurn + thing.Uniform(-0.9, 0.9)), thing, mesh);
  const Eigen::Vector2d near = hotel.In(unit, left, 0.05, kBathM + 0.65);
  const Eigen::Vector2d far = hotel.In(unit, left, hotel.unit_m - 0.1, d - 0.3);
  Floor floor(near.cwiseMin(far), near.cwiseMax(far), z, 0.45, trodden);
  floor.Take(spot(bed, bed_into, 0), {1.8, 1.5});
  floor.Take(desk.Beside(0, 0.35, 0), {1.1, 0.9});
  for (int i = 0; i < 5; ++i) {
    const Eigen::Vector3d size(thing.Uniform(0.25, 0.6), thing.Uniform(0.2, 0.45),
                               thing.Uniform(0.3, 0.8));
    const auto luggage = floor.TakeAnywhere(size.head<2>(), thing);
    if (!luggage) continue;
    As(mesh, PointClass::kObject)->AddBox(luggage->foot, size, luggage->yaw, Material::kCloth);
  }
  // Curtains: folds from either side of the window.
  const As curtain(mesh, PointClass::kWall);
  for (const double side : {-1.0, 1.0}) {
    const double drawn = thing.Uniform(0.1, 0.9) * hotel.window_m / 2;
    for (double at = 0; at < drawn; at += 0.12) {
      const double along = hotel.unit_m / 2 + side * (hotel.window_m / 2 - at);
      mesh->AddBox(spot(along, d - 0.2 + thing.Uniform(-0.04, 0.04), 0).foot,
                   {0.13, 0.05, hotel.clear_height() - 0.1}, thing.Uniform(-0.5, 0.5),
                   Material::kCloth);
    }
  }
}

void AddHotelRoom(const Hotel& hotel, int unit, bool left, double z, bool furnished, Mesh* mesh) {
  const double high = hotel.clear_height();
  const auto at = [&](double along, double into) {
    const Eigen::Vector2d p = hotel.In(unit, left, along, into);
    return Eigen::Vector3d(p.x(), p.y(), z);
  };
  const auto box = [&](double along, double into, const Eigen::Vector3d& size) {
    As(mesh, PointClass::kObject)->AddBox(at(along, into), size, 0, Material::kWood);
  };
  const double w = hotel.unit_m, d = hotel.deep_m, bath = w - hotel.entry_m;
  AddWallWithOpenings(
      at(0, 0), at(w, 0), high, kWallM,
      {{hotel.door_x() - hotel.door_m / 2, hotel.door_x() + hotel.door_m / 2, 0, 2.1, false}},
      Material::kPlaster, mesh);
  AddWallWithOpenings(at(0, d), at(w, d), high, 0.3,
                      {{(w - hotel.window_m) / 2, (w + hotel.window_m) / 2, 0.9, high - 0.3, true}},
                      Material::kPlaster, mesh);
  AddWall(at(w, 0), at(w, d), high, kWallM, Material::kPlaster, mesh);
  AddWall(at(bath, 0), at(bath, kBathM), high, kWallM, Material::kPlaster, mesh);
  AddWall(at(0, kBathM), at(bath, kBathM), high, kWallM, Material::kPlaster, mesh);
  box(0.5, kBathM + 0.06 + 0.3, {1, 0.5, 2});  // A wardrobe, a bed, a desk.
  if (!furnished) return;
  box(1.1, kBathM + 1.2, {2.0, 1.6, 0.5});
  box(0.7, d - 0.5, {1.2, 0.6, 0.75});
}

// With furniture that is alike in all rooms, or without.
void AddHotelStorey(const Hotel& hotel, int storey, bool furnished, Mesh* mesh) {
  const double z = storey * hotel.storey_m, x = hotel.length();
  const double y = hotel.corridor_m / 2 + hotel.deep_m;
  for (int unit = 0; unit < hotel.units; ++unit) {
    for (const bool left : {false, true}) AddHotelRoom(hotel, unit, left, z, furnished, mesh);
  }
  for (const double end : {0.0, x}) {
    AddWall({end, -y, z}, {end, y, z}, hotel.clear_height(), 0.3, Material::kPlaster, mesh);
  }
}

// Luggage, chairs: a few in every room and some in the corridor.
void AddLooseThings(const Hotel& hotel, const Need& need, const PathIndex& index, Mesh* mesh) {
  const int rooms = 2 * hotel.units * hotel.storeys, per_room = 4;
  const As loose(mesh, PointClass::kObject);
  for (int i = 0; i < rooms * per_room; ++i) {
    Random thing = need.season.Draw(static_cast<uint64_t>(i));
    const int room = i / per_room, storey = room / (2 * hotel.units);
    const double radius = thing.Uniform(0.15, 0.35);
    const bool outside = thing.Chance(0.15);
    const Eigen::Vector2d at =
        hotel.In(room / 2 % hotel.units, room % 2 == 1, thing.Uniform(0.4, hotel.unit_m - 0.4),
                 outside ? -0.3 : thing.Uniform(kBathM + 0.4, hotel.deep_m - 0.4));
    const Eigen::Vector3d size(thing.Uniform(1, 2) * radius, thing.Uniform(1, 2) * radius,
                               thing.Uniform(0.4, 1.6));
    if (thing.Chance(0.3) || index.Distance(at, 3) < need.clear_m() + 1.4 * radius) continue;
    mesh->AddBox({at.x(), at.y(), storey * hotel.storey_m}, size, thing.Uniform(0, 6.3),
                 Material::kWood);
  }
}

Scene BuildHotel(const Hotel& hotel, const Need& need, bool furnished, Random& random) {
  Scene scene;
  scene.path = std::make_shared<Path>(Path::Along(Stroll(hotel, need, random), 0.4));
  scene.storeys = hotel.storeys;
  scene.storey_m = hotel.storey_m;
  const double wide = hotel.corridor_m + 2 * hotel.deep_m;
  for (int storey = 0; storey <= hotel.storeys; ++storey) {
    const bool roof = storey == hotel.storeys;
    As(&scene.mesh, PointClass::kWall)
        ->AddSlab({hotel.length() / 2, 0, storey * hotel.storey_m - hotel.slab_m},
                  {hotel.length(), wide, hotel.slab_m}, 0, Material::kFloor,
                  roof ? PointClass::kCeiling : PointClass::kGround);
    if (storey < hotel.storeys) AddHotelStorey(hotel, storey, furnished, &scene.mesh);
  }
  return scene;
}

}  // namespace

Scene MakeHotel(const Need& need, Random& random) {
  const Hotel hotel = DesignHotel(need, random);
  Scene scene = BuildHotel(hotel, need, true, random);
  AddLooseThings(hotel, need, PathIndex(*scene.path), &scene.mesh);
  return scene;
}

Scene MakeInn(const Need& need, Random& random) {
  const Hotel hotel = DesignHotel(need, random);
  Scene scene = BuildHotel(hotel, need, false, random);
  const int guests = random.Chance(0.4) ? 0 : random.Index(5);
  for (int i = 0; i < guests; ++i) {
    const auto walk = std::make_shared<const Path>(
        scene.path->Moved(0, random.Index(hotel.storeys) * hotel.storey_m));
    const double speed = random.Uniform(0.5, 1.5);
    scene.walks.push_back(WalkToAndFro(walk, speed, random.Uniform(0, walk->length())));
  }
  scene.give_way_m = need.carrier.base_m / 2 + 0.45;
  if (need.bare) return scene;
  // All storeys are walked alike.
  std::vector<Eigen::Vector3d> trodden = Trodden({scene.path});
  for (int room = 0; room < 2 * hotel.units * hotel.storeys; ++room) {
    const int storey = room / (2 * hotel.units);
    const double z = storey * hotel.storey_m;
    for (Eigen::Vector3d& point : trodden) point.z() = z;
    AddOwnFurniture(hotel, room / 2 % hotel.units, room % 2 == 1, z, trodden,
                    need.season.Draw(static_cast<uint64_t>(room)), &scene.mesh);
  }
  return scene;
}

}  // namespace isthmus::simulation::wild
