#include <cmath>
#include <numbers>

#include "lab/simulation/worlds/floor_plan.h"

namespace isthmus::simulation {

bool Furnisher::Claim(const Eigen::Vector2d& center, double radius, double clearance_m) {
  for (const Circle& circle : taken_) {
    if ((circle.center - center).norm() < circle.radius + radius + 0.2) return false;
  }
  if (world_.roads.Distance(center) < radius + clearance_m) return false;
  taken_.push_back({center, radius});
  return true;
}

void Furnisher::Place(Furniture::Kind kind) {
  const size_t end = world_.mesh.vertices.size();
  const Circle& circle = taken_.back();
  world_.furniture.pieces.push_back({kind,
                                     {circle.center.x(), circle.center.y(), 0},
                                     circle.radius,
                                     placed_vertices_,
                                     end - placed_vertices_});
  placed_vertices_ = end;
}

void Furnisher::FurnishMiddle(const Room& room) {
  const Eigen::Vector2d size = room.Size();
  if (size.minCoeff() > 9 && random_.Chance(0.6)) {  // A hall with rows of columns.
    const double pitch = random_.Uniform(2.8, 4.2), radius = random_.Uniform(0.25, 0.45);
    for (double x = -2 * pitch; x < 2.5 * pitch; x += pitch) {
      for (const double y : {-pitch / 2, pitch / 2}) {
        const Eigen::Vector2d at = room.Center() + Eigen::Vector2d(x, y);
        if (((at - room.min).array() < 0.8).any() || ((room.max - at).array() < 0.8).any())
          continue;
        if (!Claim(at, radius)) continue;
        const As column(&world_.mesh, PointClass::kPole);
        world_.mesh.AddBox({at.x(), at.y(), 0}, {2.4 * radius, 2.4 * radius, 0.3}, 0,
                           Material::kStone);
        world_.mesh.AddCylinder({at.x(), at.y(), 0}, radius, kWallHeight, Material::kStone);
        Place(Furniture::Kind::kFixed);
      }
    }
  }
  const int attempts = static_cast<int>(size.prod() / 2) + 10;
  for (int i = 0; i < attempts; ++i) AddExhibit(room);
}

void Furnisher::AddExhibit(const Room& room) {
  const Eigen::Vector2d at(random_.Uniform(room.min.x() + 1.2, room.max.x() - 1.2),
                           random_.Uniform(room.min.y() + 1.2, room.max.y() - 1.2));
  const Eigen::Vector3d base(at.x(), at.y(), 0);
  const double yaw = random_.Uniform(0, std::numbers::pi);
  const double kind = random_.Unit();
  Mesh& mesh = world_.mesh;
  const As exhibit(&mesh, PointClass::kObject);
  if (kind < 0.4) {  // A show case.
    const Eigen::Vector3d size(random_.Uniform(0.7, 2.2), random_.Uniform(0.6, 1.1),
                               random_.Uniform(0.9, 1.9));
    if (!Claim(at, size.head<2>().norm() / 2)) return;
    mesh.AddBox(base, size, yaw, Material::kWood);
  } else if (kind < 0.75) {  // A statue on its pedestal.
    const double side = random_.Uniform(0.6, 1.1), foot = random_.Uniform(0.4, 1.0);
    if (!Claim(at, 0.71 * side)) return;
    mesh.AddBox(base, {side, side, foot}, yaw, Material::kStone);
    const double height = random_.Uniform(0.8, 1.8), body = random_.Uniform(0.25, 0.42) * side;
    mesh.AddCylinder(base + Eigen::Vector3d(0, 0, foot), body, height, Material::kMetal);
    mesh.AddBox(base + Eigen::Vector3d(0, 0, foot + 0.7 * height), {1.9 * body, 0.9 * body, 0.3},
                yaw + 0.6, Material::kMetal);
  } else {  // A partition with two pictures.
    const double length = random_.Uniform(2.0, 4.5);
    if (!Claim(at, length / 2)) return;
    mesh.AddBox(base, {length, 0.2, random_.Uniform(2.2, 3.0)}, yaw, Material::kPlaster);
    mesh.AddBox(base + Eigen::Vector3d(0, 0, 1.0), {0.6 * length, 0.32, 1.0}, yaw, Material::kWood);
  }
  Place(Furniture::Kind::kOnFloor);
}

void Furnisher::FurnishWalls(const Room& room) {
  constexpr double kHalfPi = std::numbers::pi / 2;
  const double inset = kWallThickness / 2;
  const Eigen::Vector2d size = room.Size() - Eigen::Vector2d::Constant(2 * inset);
  const Eigen::Vector2d corner = room.min + Eigen::Vector2d::Constant(inset);
  for (int side = 0; side < 4; ++side) {
    const double length = side % 2 == 0 ? size.x() : size.y();
    for (double s = random_.Uniform(0.6, 2.0); s < length - 0.6; s += random_.Uniform(1.2, 3.2)) {
      Eigen::Vector2d at = corner;
      if (side == 0) at += Eigen::Vector2d(s, 0);
      if (side == 1) at += Eigen::Vector2d(size.x(), s);
      if (side == 2) at += Eigen::Vector2d(size.x() - s, size.y());
      if (side == 3) at += Eigen::Vector2d(0, size.y() - s);
      AddWallPiece(at, side * kHalfPi);
    }
  }
}

// `at` lies on the wall's surface; +y of the piece's own axes (turned by yaw) points into the room.
void Furnisher::AddWallPiece(const Eigen::Vector2d& at, double yaw) {
  const Eigen::Vector2d inward(-std::sin(yaw), std::cos(yaw));
  const auto box = [&](double width, double depth, double bottom, double height, Material material,
                       Furniture::Kind kind) {
    const bool on_wall = kind == Furniture::Kind::kFixed;
    // Its claim is the circle around the half that stands in the room.
    const Eigen::Vector2d center = at + depth / 2 * inward;
    if (!Claim(center, std::max(width, depth) / 2, 0.8)) return;
    As(&world_.mesh, on_wall ? PointClass::kWall : PointClass::kObject)
        ->AddBox({center.x(), center.y(), bottom}, {width, depth, height}, yaw, material);
    Place(kind);
  };
  using enum Furniture::Kind;
  const double kind = random_.Unit();
  if (kind < 0.3) {
    box(random_.Uniform(0.4, 0.8), random_.Uniform(0.15, 0.45), 0, kWallHeight, Material::kPlaster,
        kFixed);
  } else if (kind < 0.65) {
    box(random_.Uniform(0.7, 2.0), 0.06, random_.Uniform(0.9, 1.3), random_.Uniform(0.7, 1.6),
        Material::kWood, kFixed);
  } else if (kind < 0.85) {
    box(random_.Uniform(0.8, 1.8), random_.Uniform(0.4, 0.7), 0, random_.Uniform(1.2, 2.3),
        Material::kWood, kOnFloor);
  } else {
    box(random_.Uniform(1.2, 2.0), 0.45, 0, 0.45, Material::kWood, kOnFloor);
  }
}

}  // namespace isthmus::simulation
