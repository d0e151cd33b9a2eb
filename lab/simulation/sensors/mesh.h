// Surfaces of a simulated world: triangles with a material and a class each.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/map/point_class.h"
#include "lab/simulation/random.h"

namespace isthmus::simulation {

enum class Material : uint8_t {
  kFloor,
  kPlaster,
  kStone,
  kWood,
  kMetal,
  kLeaves,
  kAsphalt,
  kSign,
  kCloth,
  kGlass,  // Effects say what comes back; without them it is hit as all else.
  kRetro,  // Sends light back to where it came from: number plates, signs, beacons.
  kSoil
};

// Share of light that comes back at normal incidence, on the scale of a sensor's intensity byte.
float Reflectivity(Material material);

// World frame, z up, metres. Value type.
struct Mesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;  // Indices into vertices.
  std::vector<Material> materials;                 // One per triangle.
  std::vector<PointClass> classes;                 // One per triangle.
  PointClass adds = PointClass::kUnknown;          // Class of what is added; see As.

  void AddTriangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                   Material material);
  // Corners in order around the edge.
  void AddQuad(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
               const Eigen::Vector3d& d, Material material);
  // `base` is the middle of the bottom face; `size` is along the box's own axes, turned by `yaw`.
  void AddBox(const Eigen::Vector3d& base, const Eigen::Vector3d& size, double yaw,
              Material material);
  // A box that is a floor or a roof: `top` is the class of its upper side, its lower side is a
  // ceiling.
  void AddSlab(const Eigen::Vector3d& base, const Eigen::Vector3d& size, double yaw,
               Material material, PointClass top);
  // Upright, round to within 2 % of the radius, closed on top.
  void AddCylinder(const Eigen::Vector3d& base, double radius, double height, Material material);
  // `count` small triangles at random in an ellipsoid: what a LiDAR sees of a tree's crown. They
  // are vegetation.
  void AddLeaves(const Eigen::Vector3d& center, const Eigen::Vector3d& radii, int count,
                 Random& random);
  // A copy of all of `other`, moved by `offset`.
  void Append(const Mesh& other, const Eigen::Vector3d& offset);
};

// While this lives, what is added to the mesh is of a class:
//   const As wall(mesh, PointClass::kWall);                 until the end of the block,
//   As(mesh, PointClass::kPole)->AddCylinder(...);          one shape.
class As {
 public:
  As(Mesh* mesh, PointClass adds) : mesh_(mesh), before_(mesh->adds) { mesh->adds = adds; }
  ~As() { mesh_->adds = before_; }
  As(const As&) = delete;
  As& operator=(const As&) = delete;

  Mesh* operator->() const { return mesh_; }
  Mesh* mesh() const { return mesh_; }

 private:
  Mesh* mesh_;
  PointClass before_;
};

}  // namespace isthmus::simulation
