#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "lab/simulation/worlds/builders.h"

namespace isthmus::simulation {
namespace {

constexpr double kPitch = 42;   // Metres between junctions, before they are moved about.
constexpr double kMargin = 24;  // Ground and buildings around the outer streets.

// Builds one campus: streets first, then what stands beside them.
class CampusBuilder {
 public:
  CampusBuilder(uint64_t seed, int blocks)
      : blocks_(blocks), extent_(blocks * kPitch + 2 * kMargin), random_(seed, 0xCA, 0) {
    world_.sensor_height_m = 1.8;
    world_.max_speed_mps = 4;
    world_.lane_m = 0.9;
    world_.has_streets = true;
    world_.overlap_cell_m = 1;
  }

  World Build() {
    MakeGround();
    MakeStreets();
    for (int i = 0; i < 40 * blocks_ * blocks_; ++i) AddBuilding();
    AlongStreets();
    for (int i = 0; i < 28 * blocks_ * blocks_; ++i) AddTree();
    return std::move(world_);
  }

 private:
  Eigen::Vector3d OnGround(const Eigen::Vector2d& p, double above = 0) const {
    return {p.x(), p.y(), world_.ground.Height(p.x(), p.y()) + above};
  }

  void MakeGround() {
    for (int i = 0; i < 6; ++i) {
      const double wave_length = random_.Uniform(35, 110);
      const double k = 2 * std::numbers::pi / wave_length;
      const double angle = random_.Uniform(0, 2 * std::numbers::pi);
      // Slopes of at most 1.2 degrees each.
      const double amplitude = random_.Uniform(0.2, 1) * 0.02 / k;
      world_.ground.waves.push_back({k * std::cos(angle), k * std::sin(angle),
                                     random_.Uniform(0, 2 * std::numbers::pi), amplitude});
    }
    const As ground(&world_.mesh, PointClass::kGround);
    constexpr double kCell = 2.5;
    constexpr double kApron = 60;  // Ground goes on beyond what is built.
    for (double x = -kApron; x < extent_ + kApron; x += kCell) {
      for (double y = -kApron; y < extent_ + kApron; y += kCell) {
        world_.mesh.AddQuad(OnGround({x, y}), OnGround({x + kCell, y}),
                            OnGround({x + kCell, y + kCell}), OnGround({x, y + kCell}),
                            Material::kAsphalt);
      }
    }
  }

  // Junctions on a grid that is moved about, with a bend half way between them; some neighbouring
  // blocks are one.
  void MakeStreets() {
    const int side = blocks_ + 1;
    using Grid = std::vector<std::vector<int>>;
    Grid junction(side, std::vector<int>(side)), right_of = junction, above = junction;
    RoadMap& roads = world_.roads;
    const auto jitter = [this](double m) -> Eigen::Vector2d {
      return {random_.Uniform(-m, m), random_.Uniform(-m, m)};
    };
    for (int i = 0; i < side; ++i) {
      for (int j = 0; j < side; ++j) {
        const Eigen::Vector2d at(kMargin + i * kPitch, kMargin + j * kPitch);
        junction[i][j] = roads.AddNode(at + jitter(6), true);
      }
    }
    for (int i = 0; i < side; ++i) {
      for (int j = 0; j < side; ++j) {
        const auto middle = [&](int other) {
          return roads.AddNode((roads.nodes[junction[i][j]] + roads.nodes[other]) / 2 + jitter(3),
                               true);
        };
        if (i < blocks_) right_of[i][j] = middle(junction[i + 1][j]);
        if (j < blocks_) above[i][j] = middle(junction[i][j + 1]);
      }
    }
    for (int j = 0; j < blocks_; ++j) {
      for (int i = 0; i < blocks_; ++i) {
        const int last = i + 1 < blocks_ && random_.Chance(0.2) ? i + 1 : i;
        std::vector<int> cycle;
        for (int k = i; k <= last; ++k) {
          cycle.insert(cycle.end(), {junction[k][j], right_of[k][j]});
        }
        cycle.insert(cycle.end(), {junction[last + 1][j], above[last + 1][j]});
        for (int k = last; k >= i; --k) {
          cycle.insert(cycle.end(), {junction[k + 1][j + 1], right_of[k][j + 1]});
        }
        cycle.insert(cycle.end(), {junction[i][j + 1], above[i][j]});
        roads.AddPlace(cycle);
        i = last;
      }
    }
  }

  Eigen::Vector2d Anywhere() { return {random_.Uniform(0, extent_), random_.Uniform(0, extent_)}; }

  bool IsFree(const Eigen::Vector2d& p, double from_buildings, double from_things) const {
    for (const auto& q : built_) {
      if ((p - q).squaredNorm() < from_buildings * from_buildings) return false;
    }
    for (const auto& q : things_) {
      if ((p - q).squaredNorm() < from_things * from_things) return false;
    }
    return true;
  }

  struct Part {  // A rectangle of a footprint, in the building's own axes.
    double x, y, width, depth;
  };

  std::vector<Part> Footprint() {
    const double w = random_.Uniform(9, 24), d = random_.Uniform(8, 14);
    const double wing = random_.Uniform(6, 9), out = random_.Uniform(5, 12);
    std::vector<Part> parts{{0, 0, w, d}};
    const double y = (d + out) / 2 - 0.5, x = (w - wing) / 2;
    const int kind = random_.Index(6);
    if (kind == 1 || kind == 3) parts.push_back({x, y, wing, out + 1});                  // L, U.
    if (kind == 3) parts.push_back({-x, y, wing, out + 1});                              // U.
    if (kind == 2) parts.push_back({random_.Uniform(-0.3, 0.3) * w, y, wing, out + 1});  // T.
    if (kind == 4) {                                                                     // Z.
      parts.push_back({x, y, wing, out + 1});
      parts.push_back({-x, -y, wing, out + 1});
    }
    return parts;
  }

  void AddBuilding() {
    const Eigen::Vector2d center = Anywhere();
    const double yaw = random_.Index(4) * std::numbers::pi / 2 + random_.Uniform(-0.25, 0.25);
    const Eigen::Vector2d ex(std::cos(yaw), std::sin(yaw)), ey(-ex.y(), ex.x());
    const std::vector<Part> parts = Footprint();
    std::vector<Eigen::Vector2d> covered;
    for (const Part& part : parts) {
      for (double x = -part.width / 2; x <= part.width / 2; x += part.width / 8) {
        for (double y = -part.depth / 2; y <= part.depth / 2; y += part.depth / 6) {
          covered.push_back(center + (part.x + x) * ex + (part.y + y) * ey);
        }
      }
    }
    for (const auto& p : covered) {
      if (world_.roads.Distance(p) < 5.5 || !IsFree(p, 5.0, 0)) return;
    }
    built_.insert(built_.end(), covered.begin(), covered.end());
    for (const Part& part : parts) {
      AddPart(center + part.x * ex + part.y * ey, part, yaw, random_.Uniform(4.5, 13));
    }
  }

  // A block of a building, with what stands out of its walls: porches, bays, pilasters, a cornice.
  void AddPart(const Eigen::Vector2d& center, const Part& part, double yaw, double height) {
    const Eigen::Vector2d ex(std::cos(yaw), std::sin(yaw)), ey(-ex.y(), ex.x());
    Mesh& mesh = world_.mesh;
    const As wall(&mesh, PointClass::kWall);
    constexpr PointClass kRoof = PointClass::kCeiling;
    const double foundation = 1.5;
    mesh.AddSlab(OnGround(center, -foundation), {part.width, part.depth, height + foundation}, yaw,
                 Material::kPlaster, kRoof);
    mesh.AddSlab(OnGround(center, height), {part.width + 0.8, part.depth + 0.8, 0.3}, yaw,
                 Material::kStone, kRoof);
    for (int side = 0; side < 4; ++side) {
      const bool long_side = side % 2 == 0;
      const Eigen::Vector2d along = long_side ? ex : ey, out = long_side ? ey : ex;
      const double sign = side < 2 ? 1 : -1;
      const double half = (long_side ? part.width : part.depth) / 2;
      const double face = (long_side ? part.depth : part.width) / 2;
      for (double s = -half + random_.Uniform(0.5, 3); s < half - 1; s += random_.Uniform(1.8, 5)) {
        const bool bay = random_.Chance(0.35);
        const double depth = bay ? random_.Uniform(0.5, 1.2) : random_.Uniform(0.15, 0.4);
        const double width = bay ? random_.Uniform(1.4, 2.6) : random_.Uniform(0.3, 0.8);
        const double top = bay ? random_.Uniform(2.4, height) : height;
        const Eigen::Vector2d at = center + s * along + sign * (face + depth / 2) * out;
        mesh.AddSlab(OnGround(at, -foundation),
                     long_side ? Eigen::Vector3d(width, depth, top + foundation)
                               : Eigen::Vector3d(depth, width, top + foundation),
                     yaw, bay ? Material::kStone : Material::kPlaster, kRoof);
      }
    }
  }

  // Lamp posts, parked cars and fences on both sides of every street.
  void AlongStreets() {
    const RoadMap& roads = world_.roads;
    for (size_t a = 0; a < roads.nodes.size(); ++a) {
      for (const int b : roads.neighbours[a]) {  // Each direction has its right side.
        const Eigen::Vector2d span = roads.nodes[b] - roads.nodes[a];
        const Eigen::Vector2d along = span.normalized(), right(along.y(), -along.x());
        const double yaw = std::atan2(along.y(), along.x());
        for (double s = random_.Uniform(5, 9); s < span.norm() - 5; s += random_.Uniform(4, 9)) {
          const Eigen::Vector2d at = roads.nodes[a] + s * along;
          const double kind = random_.Unit();
          if (kind < 0.3) AddPost(at + 4.4 * right, yaw);
          if (kind > 0.5 && kind < 0.85) AddCar(at + 4.0 * right, yaw + random_.Uniform(-.05, .05));
          if (kind > 0.85) AddFence(at + 5.0 * right, yaw, random_.Uniform(4, 9));
        }
      }
    }
  }

  bool Claim(const Eigen::Vector2d& at, double from_roads, double from_buildings, double apart) {
    if (world_.roads.Distance(at) < from_roads || !IsFree(at, from_buildings, apart)) return false;
    things_.push_back(at);
    return true;
  }

  void AddPost(const Eigen::Vector2d& at, double yaw) {
    if (!Claim(at, 3.5, 2.2, 2)) return;
    const As post(&world_.mesh, PointClass::kPole);
    world_.mesh.AddCylinder(OnGround(at), random_.Uniform(0.06, 0.11), random_.Uniform(4.5, 7),
                            Material::kMetal);
    if (random_.Chance(0.35)) {
      world_.mesh.AddBox(OnGround(at, 2.2), {0.06, 0.7, 0.7}, yaw, Material::kSign);
    }
  }

  void AddCar(const Eigen::Vector2d& at, double yaw) {
    if (!Claim(at, 3.6, 3.2, 3)) return;
    const double length = random_.Uniform(3.8, 4.8), height = random_.Uniform(0.75, 0.95);
    const Eigen::Vector2d forward(std::cos(yaw), std::sin(yaw));
    const As car(&world_.mesh, PointClass::kVehicle);
    world_.mesh.AddBox(OnGround(at, 0.25), {length, 1.8, height - 0.25}, yaw, Material::kMetal);
    world_.mesh.AddBox(OnGround(at - 0.3 * forward, height), {0.5 * length, 1.55, 0.6}, yaw,
                       Material::kMetal);
  }

  void AddFence(const Eigen::Vector2d& at, double yaw, double length) {
    if (!Claim(at, 4, length / 2 + 1, length / 2 + 0.5)) return;
    const bool hedge = random_.Chance(0.5);
    const Eigen::Vector3d size(length, hedge ? 0.7 : 0.08, random_.Uniform(0.9, 1.7));
    As(&world_.mesh, hedge ? PointClass::kVegetation : PointClass::kStructure)
        ->AddBox(OnGround(at, -0.4), size + Eigen::Vector3d(0, 0, 0.4), yaw,
                 hedge ? Material::kLeaves : Material::kMetal);
  }

  void AddTree() {
    const Eigen::Vector2d at = Anywhere();
    if (!Claim(at, 4.2, 3.2, 3.5)) return;
    const double trunk = random_.Uniform(1.8, 3.2), crown = random_.Uniform(1.2, 2.6);
    const double tall = random_.Uniform(1.0, 1.6) * crown;
    As(&world_.mesh, PointClass::kPole)
        ->AddCylinder(OnGround(at, -0.3), random_.Uniform(0.1, 0.3), trunk + crown,
                      Material::kWood);
    world_.mesh.AddLeaves(OnGround(at, trunk + tall), {crown, crown, tall},
                          static_cast<int>(25 * crown * crown), random_);
  }

  const int blocks_;  // Along either side.
  const double extent_;
  World world_;
  Random random_;
  std::vector<Eigen::Vector2d> built_;   // Points all over the footprints.
  std::vector<Eigen::Vector2d> things_;  // Other things that stand about.
};

}  // namespace

World MakeCampus(uint64_t seed, int blocks) { return CampusBuilder(seed, blocks).Build(); }

}  // namespace isthmus::simulation
