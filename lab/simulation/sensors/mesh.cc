#include "lab/simulation/sensors/mesh.h"

#include <cmath>
#include <numbers>

namespace isthmus::simulation {

float Reflectivity(Material material) {
  switch (material) {
    case Material::kFloor:
      return 40;
    case Material::kPlaster:
      return 90;
    case Material::kStone:
      return 60;
    case Material::kWood:
      return 30;
    case Material::kMetal:
      return 110;
    case Material::kLeaves:
      return 50;
    case Material::kAsphalt:
      return 15;
    case Material::kSign:
      return 200;
    case Material::kCloth:
      return 45;
    case Material::kGlass:
      return 12;
    case Material::kRetro:
      return 255;
    case Material::kSoil:
      return 28;
  }
  return 0;
}

void Mesh::AddTriangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                       Material material) {
  const auto first = static_cast<uint32_t>(vertices.size());
  for (const auto& corner : {a, b, c}) vertices.push_back(corner.cast<float>());
  triangles.push_back({first, first + 1, first + 2});
  materials.push_back(material);
  classes.push_back(adds);
}

void Mesh::AddQuad(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                   const Eigen::Vector3d& d, Material material) {
  AddTriangle(a, b, c, material);
  AddTriangle(a, c, d, material);
}

void Mesh::AddBox(const Eigen::Vector3d& base, const Eigen::Vector3d& size, double yaw,
                  Material material) {
  const double c = std::cos(yaw), s = std::sin(yaw);
  const auto corner = [&](int i) -> Eigen::Vector3d {
    const double x = (i & 1 ? 0.5 : -0.5) * size.x(), y = (i & 2 ? 0.5 : -0.5) * size.y();
    return base + Eigen::Vector3d(c * x - s * y, s * x + c * y, i & 4 ? size.z() : 0);
  };
  constexpr int kFaces[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
  for (const auto& f : kFaces) {
    AddQuad(corner(f[0]), corner(f[1]), corner(f[2]), corner(f[3]), material);
  }
}

void Mesh::AddSlab(const Eigen::Vector3d& base, const Eigen::Vector3d& size, double yaw,
                   Material material, PointClass top) {
  const size_t first = classes.size();
  AddBox(base, size, yaw, material);
  for (const size_t i : {0, 1}) {  // Two triangles below, then two above.
    classes[first + i] = PointClass::kCeiling;
    classes[first + 2 + i] = top;
  }
}

void Mesh::AddCylinder(const Eigen::Vector3d& base, double radius, double height,
                       Material material) {
  constexpr int kSides = 16;  // 1 - cos(pi / 16) = 1.9 % of the radius.
  const Eigen::Vector3d up(0, 0, height);
  const auto rim = [&](int i) -> Eigen::Vector3d {
    const double angle = 2 * std::numbers::pi * i / kSides;
    return base + radius * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
  };
  for (int i = 0; i < kSides; ++i) {
    const Eigen::Vector3d a = rim(i), b = rim(i + 1);
    AddQuad(a, b, b + up, a + up, material);
    AddTriangle(a + up, b + up, base + up, material);
  }
}

void Mesh::AddLeaves(const Eigen::Vector3d& center, const Eigen::Vector3d& radii, int count,
                     Random& random) {
  const As leaves(this, PointClass::kVegetation);
  const auto ball = [&random] {
    return Eigen::Vector3d(random.Normal(), random.Normal(), random.Normal());
  };
  for (int i = 0; i < count; ++i) {
    // Denser towards the outside, as crowns are.
    const double r = std::pow(random.Unit(), 0.25);
    const Eigen::Vector3d at = center + r * ball().normalized().cwiseProduct(radii);
    AddTriangle(at + 0.25 * ball(), at + 0.25 * ball(), at + 0.25 * ball(), Material::kLeaves);
  }
}

void Mesh::Append(const Mesh& other, const Eigen::Vector3d& offset) {
  const auto first = static_cast<uint32_t>(vertices.size());
  for (const auto& v : other.vertices) vertices.push_back(v + offset.cast<float>());
  for (const auto& t : other.triangles) {
    triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  materials.insert(materials.end(), other.materials.begin(), other.materials.end());
  classes.insert(classes.end(), other.classes.begin(), other.classes.end());
}

}  // namespace isthmus::simulation
