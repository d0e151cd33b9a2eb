#include "lab/simulation/wild/furniture.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lab/simulation/wild/shapes.h"

namespace isthmus::simulation::wild {
namespace {

void Box(const Spot& spot, const Eigen::Vector3d& foot, const Eigen::Vector3d& size,
         Material material, Mesh* mesh) {
  mesh->AddBox(spot.At(foot.x(), foot.y(), foot.z()), size, spot.yaw, material);
}

// Legs under the corners.
void AddLegs(const Spot& spot, const Eigen::Vector2d& size, double height_m, double thick_m,
             Mesh* mesh) {
  const Eigen::Vector2d half = (size.array() - thick_m) / 2;
  for (const double x : {-half.x(), half.x()}) {
    for (const double y : {-half.y(), half.y()}) {
      Box(spot, {x, y, 0}, {thick_m, thick_m, height_m}, Material::kWood, mesh);
    }
  }
}

}  // namespace

Eigen::Vector3d Spot::At(double x, double y, double z) const {
  const double c = std::cos(yaw), s = std::sin(yaw);
  return foot + Eigen::Vector3d(c * x - s * y, s * x + c * y, z);
}

void AddTable(const Spot& spot, const Eigen::Vector3d& size, Mesh* mesh) {
  const As furniture(mesh, PointClass::kObject);
  constexpr double kTop = 0.04;
  AddLegs(spot, size.head<2>(), size.z() - kTop, 0.06, mesh);
  Box(spot, {0, 0, size.z() - kTop}, {size.x(), size.y(), kTop}, Material::kWood, mesh);
}

void AddChair(const Spot& spot, Random& random, Mesh* mesh) {
  const As furniture(mesh, PointClass::kObject);
  const double side = random.Uniform(0.4, 0.48), high = random.Uniform(0.42, 0.48);
  AddLegs(spot, {side, side}, high, 0.04, mesh);
  Box(spot, {0, 0, high}, {side, side, 0.04}, Material::kWood, mesh);
  Box(spot, {0, -side / 2, high}, {side, 0.04, random.Uniform(0.35, 0.55)}, Material::kWood, mesh);
}

void AddSwivelChair(const Spot& spot, Random& random, Mesh* mesh) {
  const As furniture(mesh, PointClass::kObject);
  const double high = random.Uniform(0.42, 0.55), turned = random.Uniform(0, 6.3);
  for (int i = 0; i < 5; ++i) {
    const double angle = turned + 2 * std::numbers::pi * i / 5;
    AddTube(spot.At(0, 0, 0.08), spot.At(0.3 * std::cos(angle), 0.3 * std::sin(angle), 0.04), 0.03,
            0.03, 4, Material::kMetal, mesh);
  }
  mesh->AddCylinder(spot.At(0, 0, 0.06), 0.03, high - 0.06, Material::kMetal);
  Box(spot, {0, 0, high}, {0.5, 0.48, 0.08}, Material::kCloth, mesh);
  Box(spot, {0, -0.26, high + 0.15}, {0.46, 0.06, random.Uniform(0.4, 0.65)}, Material::kCloth,
      mesh);
}

void AddDesk(const Spot& spot, const Eigen::Vector3d& size, Random& random, Mesh* mesh) {
  const As furniture(mesh, PointClass::kObject);
  AddTable(spot, size, mesh);
  const double side = random.Chance(0.5) ? 1 : -1;
  if (random.Chance(0.7)) {  // Drawers.
    Box(spot, {side * (size.x() / 2 - 0.28), 0, 0}, {0.42, size.y() - 0.15, 0.58}, Material::kWood,
        mesh);
  }
  for (int i = random.Index(3); i > 0; --i) {  // Screens.
    const Spot screen = spot.Beside(random.Uniform(-0.4, 0.4) * size.x(),
                                    random.Uniform(-0.3, 0) * size.y(), random.Uniform(-0.4, 0.4));
    mesh->AddBox(screen.At(0, 0, size.z()), {0.2, 0.18, 0.02}, screen.yaw, Material::kMetal);
    mesh->AddBox(screen.At(0, 0, size.z()), {0.05, 0.04, 0.15}, screen.yaw, Material::kMetal);
    mesh->AddBox(screen.At(0, 0, size.z() + 0.12), {random.Uniform(0.45, 0.7), 0.03, 0.34},
                 screen.yaw, Material::kMetal);
  }
  for (int i = random.Index(4); i > 0; --i) {  // Paper, cups, boxes.
    const Spot thing = spot.Beside(random.Uniform(-0.45, 0.45) * size.x(),
                                   random.Uniform(-0.4, 0.4) * size.y(), random.Uniform(0, 6.3));
    mesh->AddBox(thing.At(0, 0, size.z()), {0.3, 0.21, random.Uniform(0.02, 0.2)}, thing.yaw,
                 Material::kWood);
  }
}

void AddBed(const Spot& spot, const Eigen::Vector3d& size, Random& random, Mesh* mesh) {
  const As furniture(mesh, PointClass::kObject);
  const double x = size.x(), y = size.y(), z = size.z();
  Box(spot, {0, 0, 0.08}, {x, y, z - 0.08}, Material::kCloth, mesh);
  Box(spot, {0, -y / 2 + 0.03, 0}, {x, 0.06, random.Uniform(0.7, 1.2)}, Material::kWood, mesh);
  for (double at = -x / 2 + 0.4; at < x / 2; at += 0.8) {  // Pillows.
    const Spot pillow =
        spot.Beside(at, -y / 2 + random.Uniform(0.3, 0.45), random.Uniform(-0.3, 0.3));
    mesh->AddBox(pillow.At(0, 0, z), {0.65, 0.4, random.Uniform(0.1, 0.2)}, pillow.yaw,
                 Material::kCloth);
  }
  const double drawn = random.Uniform(0.3, 0.7) * y;  // The blanket, drawn back.
  Box(spot, {random.Uniform(-0.08, 0.08), (y - drawn) / 2, z},
      {x * random.Uniform(0.9, 1.05), drawn, random.Uniform(0.05, 0.2)}, Material::kCloth, mesh);
}

void AddSofa(const Spot& spot, const Eigen::Vector3d& size, Random& random, Mesh* mesh) {
  const As furniture(mesh, PointClass::kObject);
  const double x = size.x(), y = size.y(), seat = 0.42;
  Box(spot, {0, 0, 0.05}, {x, y, seat - 0.05}, Material::kCloth, mesh);
  Box(spot, {0, -y / 2 + 0.12, seat}, {x, 0.24, size.z() - seat}, Material::kCloth, mesh);
  for (const double side : {-1.0, 1.0}) {
    Box(spot, {side * (x / 2 - 0.09), 0, seat}, {0.18, y, 0.2}, Material::kCloth, mesh);
  }
  for (int i = random.Index(4); i > 0; --i) {  // Cushions.
    const Spot cushion = spot.Beside(random.Uniform(-0.4, 0.4) * x, random.Uniform(-0.1, 0.1),
                                     random.Uniform(-0.6, 0.6));
    mesh->AddBox(cushion.At(0, 0, seat), {0.42, 0.2, 0.4}, cushion.yaw, Material::kCloth);
  }
}

void AddShelf(const Spot& spot, const Eigen::Vector3d& size, Random& random, Mesh* mesh) {
  const As furniture(mesh, PointClass::kObject);
  constexpr double kBoard = 0.02;
  const double x = size.x(), y = size.y(), z = size.z();
  for (const double side : {-1.0, 1.0}) {
    Box(spot, {side * (x - kBoard) / 2, 0, 0}, {kBoard, y, z}, Material::kWood, mesh);
  }
  Box(spot, {0, -y / 2 + 0.005, 0}, {x, 0.01, z}, Material::kWood, mesh);
  const int boards = std::max(2, static_cast<int>(std::lround(z / random.Uniform(0.3, 0.45))));
  for (int i = 0; i <= boards; ++i) {
    const double low = i * (z - kBoard) / boards, free = (z - kBoard) / boards - kBoard;
    Box(spot, {0, 0, low}, {x, y, kBoard}, Material::kWood, mesh);
    if (i == boards) break;
    // Books and boxes, as deep and as high as they are.
    for (double at = -x / 2 + 0.04; at < x / 2 - 0.1;) {
      const double wide = std::min(random.Uniform(0.06, 0.4), x / 2 - 0.03 - at);
      const double deep = random.Uniform(0.5, 0.95) * y, high = random.Uniform(0.4, 0.95) * free;
      if (random.Chance(0.75)) {
        Box(spot, {at + wide / 2, (deep - y) / 2 + 0.01, low + kBoard}, {wide, deep, high},
            random.Chance(0.7) ? Material::kWood : Material::kPlaster, mesh);
      }
      at += wide + (random.Chance(0.3) ? random.Uniform(0, 0.2) : 0.003);
    }
  }
}

void AddKitchenLine(const Spot& spot, double width_m, Random& random, Mesh* mesh) {
  const As furniture(mesh, PointClass::kObject);
  const double fridge = random.Chance(0.5) ? 0.6 : -0.6;  // At either end.
  const double line = width_m - 0.6, off = -fridge / 2;
  Box(spot, {std::copysign(width_m / 2 - 0.3, fridge), 0, 0}, {0.6, 0.6, random.Uniform(1.5, 2)},
      Material::kMetal, mesh);
  Box(spot, {off, 0, 0.1}, {line, 0.58, 0.78}, Material::kWood, mesh);
  Box(spot, {off, 0.01, 0.88}, {line, 0.6, 0.04}, Material::kStone, mesh);
  Box(spot, {off, -0.12, 1.45}, {line, 0.34, random.Uniform(0.5, 0.75)}, Material::kWood, mesh);
  for (int i = 3 + random.Index(6); i > 0; --i) {  // Pots, cans, a kettle.
    mesh->AddCylinder(
        spot.At(off + random.Uniform(-0.45, 0.45) * line, random.Uniform(-0.2, 0.2), 0.92),
        random.Uniform(0.04, 0.13), random.Uniform(0.08, 0.35), Material::kMetal);
  }
}

void AddPlantPot(const Spot& spot, double height_m, Random& random, Mesh* mesh) {
  const As furniture(mesh, PointClass::kObject);
  const double pot = random.Uniform(0.12, 0.22), high = random.Uniform(0.2, 0.4);
  mesh->AddCylinder(spot.foot, pot, high, Material::kStone);
  AddTube(spot.At(0, 0, high), spot.At(random.Uniform(-0.1, 0.1), 0, height_m * 0.7), 0.02, 0.01, 4,
          Material::kWood, As(mesh, PointClass::kVegetation).mesh());
  const double crown = (height_m - high) / 2;
  AddFoliage(spot.At(0, 0, high + crown), {0.3, 0.3, crown}, 90, 0.12, random, mesh);
}

void AddLamp(const Spot& spot, double height_m, Mesh* mesh) {
  const As furniture(mesh, PointClass::kObject);
  mesh->AddCylinder(spot.foot, 0.15, 0.03, Material::kMetal);
  AddTube(spot.foot, spot.At(0, 0, height_m), 0.015, 0.015, 6, Material::kMetal, mesh);
  AddTube(spot.At(0, 0, height_m - 0.15), spot.At(0, 0, height_m + 0.12), 0.22, 0.12, 12,
          Material::kCloth, mesh);
}

void AddCartons(const Spot& spot, double side_m, Random& random, Mesh* mesh) {
  const As furniture(mesh, PointClass::kObject);
  double z = 0;
  for (int i = 1 + random.Index(3); i > 0; --i) {
    const Eigen::Vector3d size(side_m * random.Uniform(0.75, 1), side_m * random.Uniform(0.6, 1),
                               random.Uniform(0.25, 0.45));
    mesh->AddBox(spot.At(random.Uniform(-0.04, 0.04), 0, z), size,
                 spot.yaw + random.Uniform(-0.2, 0.2), Material::kWood);
    z += size.z();
  }
}

void AddParkedCar(const Eigen::Vector3d& on_ground, double yaw, Random& random, Mesh* mesh) {
  const As vehicle(mesh, PointClass::kVehicle);
  const Spot spot{on_ground, yaw};
  const bool van = random.Chance(0.12);
  const double large = random.Unit();
  const double x = van ? random.Uniform(4.6, 4.9) : 3.6 + 1.2 * large + random.Uniform(-0.1, 0.1);
  const double y = van ? random.Uniform(1.9, 2.0) : 1.66 + 0.2 * large;
  const double high = van ? random.Uniform(1.9, 2.1) : random.Uniform(1.4, 1.7);
  const double waist = van ? 1.1 : random.Uniform(0.8, 0.95), under = random.Uniform(0.16, 0.25);
  const double wheel = random.Uniform(0.29, 0.36);
  Box(spot, {0, 0, under}, {x, y, waist - under}, Material::kMetal, mesh);
  // The cabin: its roof is shorter than its foot, ahead and behind.
  const double nose = x / 2 - (van ? 0.9 : random.Uniform(1.0, 1.3));
  const double tail = -x / 2 + (van ? 0.05 : random.Chance(0.4) ? random.Uniform(0.6, 0.9) : 0.1);
  const double roof_nose = nose - random.Uniform(0.4, 0.8);
  const double roof_tail = tail + (van ? 0.05 : random.Uniform(0.2, 0.6));
  const double foot_y = y / 2 - 0.06, roof_y = y / 2 - 0.22;
  const auto at = [&](double ahead, double left, double up) { return spot.At(ahead, left, up); };
  for (const double side : {-1.0, 1.0}) {
    mesh->AddQuad(at(tail, side * foot_y, waist), at(nose, side * foot_y, waist),
                  at(roof_nose, side * roof_y, high), at(roof_tail, side * roof_y, high),
                  Material::kMetal);
    for (const double axle : {-0.31, 0.31}) {
      const double left = side * (y / 2 - 0.12);
      AddTube(at(axle * x, left - 0.11, wheel), at(axle * x, left + 0.11, wheel), wheel, wheel, 12,
              Material::kAsphalt, mesh);
    }
    Box(spot, {nose - 0.2, side * (y / 2 + 0.08), waist}, {0.12, 0.16, 0.14}, Material::kMetal,
        mesh);  // Mirrors.
  }
  mesh->AddQuad(at(nose, -foot_y, waist), at(nose, foot_y, waist), at(roof_nose, roof_y, high),
                at(roof_nose, -roof_y, high), Material::kGlass);
  mesh->AddQuad(at(tail, -foot_y, waist), at(tail, foot_y, waist), at(roof_tail, roof_y, high),
                at(roof_tail, -roof_y, high), Material::kMetal);
  mesh->AddQuad(at(roof_tail, -roof_y, high), at(roof_tail, roof_y, high),
                at(roof_nose, roof_y, high), at(roof_nose, -roof_y, high), Material::kMetal);
}

}  // namespace isthmus::simulation::wild
