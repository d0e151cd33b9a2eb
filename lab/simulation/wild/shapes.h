// Shapes of the objects that stand in wild worlds.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "lab/simulation/random.h"
#include "lab/simulation/sensors/mesh.h"
#include "lab/simulation/wild/path.h"
#include "lab/simulation/wild/terrain.h"

namespace isthmus::simulation::wild {

// A round bar from one point to the other, open at its ends.
void AddTube(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius_from,
             double radius_to, int sides, Material material, Mesh* mesh);

// `count` triangles of about `leaf_m` at random in an ellipsoid.
void AddFoliage(const Eigen::Vector3d& center, const Eigen::Vector3d& radii, int count,
                double leaf_m, Random& random, Mesh* mesh);

// A tree on its foot: a trunk, some boughs, a crown.
struct Tree {
  double height_m = 0, radius_m = 0;  // radius_m: at the trunk's foot.
  double bare_m = 0;                  // Up to there is nothing but the trunk.
  int leaves = 0;
};
void AddTree(const Eigen::Vector3d& foot, const Tree& tree, Random& random, Mesh* mesh);

void AddBush(const Eigen::Vector3d& foot, double radius_m, int leaves, Random& random, Mesh* mesh);

void AddBoulder(const Eigen::Vector3d& center, double radius_m, Random& random, Mesh* mesh);

// An upright wall from one point to another (their z is its foot), `thickness_m` thick; or a
// parapet of that shape.
void AddWall(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double height_m,
             double thickness_m, Material material, Mesh* mesh);
void AddParapet(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double height_m,
                double thickness_m, Material material, Mesh* mesh);

// An upright band beside a path, from `s_from` to `s_to`: `bottom_m` to `top_m` above the ground
// there, or above the path where `ground` is null. A guard rail, or a kerb if it is of stone.
struct Band {
  double s_from = 0, s_to = 0, left_m = 0, bottom_m = 0, top_m = 0;
  Material material = Material::kMetal;
};
void AddBand(const Path& path, const Band& band, const HeightAt& ground, Mesh* mesh);

// An upright wall along a line, `thickness_m` thick, with openings: doors, or windows of glass.
struct Opening {
  double from_m = 0, to_m = 0;  // Along the wall.
  double bottom_m = 0, top_m = 2;
  bool glazed = false;
};
void AddWallWithOpenings(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double height_m,
                         double thickness_m, const std::vector<Opening>& openings,
                         Material material, Mesh* mesh);

// A house: walls with windows of glass, a roof.
void AddHouse(const Eigen::Vector3d& base, const Eigen::Vector3d& size, double yaw, Random& random,
              Mesh* mesh);

}  // namespace isthmus::simulation::wild
