#include "lab/simulation/worlds/another_day.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <numbers>
#include <optional>
#include <utility>

namespace isthmus::simulation {
namespace {

using Piece = Furniture::Piece;

constexpr double kApartM = 0.3;     // Between what is put down and all else.
constexpr double kOffRoadM = 0.95;  // As where furniture stands at first.
constexpr int kAttempts = 1000;

struct Place {
  Eigen::Vector3d base;
  double turn = 0;
};

class Mover {
 public:
  Mover(Random& random, World* world) : random_(random), world_(*world) {
    stood_ = world_.furniture.pieces;
  }

  std::vector<MovedVolume> Move(const Piece& piece) {
    const double what = random_.Unit();
    const std::optional<Place> place = what < 0.8 ? FindPlace(piece) : std::nullopt;
    std::vector<MovedVolume> volumes;
    if (!place || what < 0.6) volumes.push_back({false, Bounds(piece)});
    if (place) volumes.push_back({true, Copy(piece, *place)});
    if (!place || what < 0.6) Remove(piece);
    return volumes;
  }

 private:
  Eigen::AlignedBox3d Bounds(const Piece& piece) const {
    Eigen::AlignedBox3d box;
    for (size_t i = 0; i < piece.vertices; ++i) {
      box.extend(world_.mesh.vertices[piece.first_vertex + i].cast<double>());
    }
    return box;
  }

  // None where there is no room.
  std::optional<Place> FindPlace(const Piece& piece) {
    if (piece.kind == Furniture::Kind::kOnShelf) {
      auto& shelves = world_.furniture.empty_shelves;
      if (shelves.empty()) return {};
      std::swap(shelves[random_.Index(static_cast<int>(shelves.size()))], shelves.back());
      const Place place{shelves.back(), 0};
      shelves.pop_back();
      return place;
    }
    const auto& floors = world_.furniture.floors;
    for (int i = 0; i < kAttempts; ++i) {
      const auto& floor = floors[random_.Index(static_cast<int>(floors.size()))];
      const Eigen::Vector2d at(random_.Uniform(floor.min.x(), floor.max.x()),
                               random_.Uniform(floor.min.y(), floor.max.y()));
      const double room = piece.radius + kApartM;
      const bool inside =
          ((at - floor.min).array() > room).all() && ((floor.max - at).array() > room).all();
      if (!inside || world_.roads.Distance(at) < piece.radius + kOffRoadM || !IsClear(at, room)) {
        continue;
      }
      stood_.push_back({piece.kind, {at.x(), at.y(), 0}, piece.radius});
      return Place{{at.x(), at.y(), piece.base.z()}, random_.Uniform(0, std::numbers::pi)};
    }
    return {};
  }

  bool IsClear(const Eigen::Vector2d& at, double room) const {
    return std::ranges::none_of(stood_, [&](const Piece& other) {
      return other.kind != Furniture::Kind::kOnShelf &&
             (other.base.head<2>() - at).norm() < other.radius + room;
    });
  }

  Eigen::AlignedBox3d Copy(const Piece& piece, const Place& place) {
    Mesh& mesh = world_.mesh;
    const Eigen::AngleAxisd turn(place.turn, Eigen::Vector3d::UnitZ());
    Piece copy{piece.kind, place.base, piece.radius, mesh.vertices.size(), piece.vertices};
    for (size_t i = 0; i < piece.vertices; ++i) {
      const Eigen::Vector3d v = mesh.vertices[piece.first_vertex + i].cast<double>() - piece.base;
      mesh.vertices.push_back((place.base + turn * v).cast<float>());
    }
    const auto by = static_cast<uint32_t>(copy.first_vertex - piece.first_vertex);
    for (size_t t = 0, count = mesh.triangles.size(); t < count; ++t) {
      const std::array<uint32_t, 3> triangle = mesh.triangles[t];
      if (!IsOf(piece, triangle)) continue;
      mesh.triangles.push_back({triangle[0] + by, triangle[1] + by, triangle[2] + by});
      mesh.materials.push_back(Material{mesh.materials[t]});
      mesh.classes.push_back(PointClass{mesh.classes[t]});
    }
    return Bounds(copy);
  }

  static bool IsOf(const Piece& piece, const std::array<uint32_t, 3>& triangle) {
    return triangle[0] >= piece.first_vertex && triangle[0] < piece.first_vertex + piece.vertices;
  }

  // Its vertices stay, so that those of others keep their numbers.
  void Remove(const Piece& piece) {
    Mesh& mesh = world_.mesh;
    size_t kept = 0;
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
      if (IsOf(piece, mesh.triangles[t])) continue;
      mesh.triangles[kept] = mesh.triangles[t];
      mesh.materials[kept] = mesh.materials[t];
      mesh.classes[kept++] = mesh.classes[t];
    }
    mesh.triangles.resize(kept);
    mesh.materials.resize(kept);
    mesh.classes.resize(kept);
  }

  Random& random_;
  World& world_;
  std::vector<Piece> stood_;  // And what came since.
};

}  // namespace

absl::StatusOr<std::vector<MovedVolume>> MoveFurniture(int count, Random& random, World* world) {
  std::vector<Piece> loose;
  for (const Piece& piece : world->furniture.pieces) {
    if (piece.kind != Furniture::Kind::kFixed) loose.push_back(piece);
  }
  if (world->furniture.floors.empty()) loose.clear();
  if (count < 0 || static_cast<size_t>(count) > loose.size()) {
    return absl::InvalidArgumentError(absl::StrCat("in this world 0 to ", loose.size(),
                                                   " pieces of furniture can move, not ", count,
                                                   "; museum and warehouse have some"));
  }
  Mover mover(random, world);
  std::vector<MovedVolume> volumes;
  for (int i = 0; i < count; ++i) {
    std::swap(loose[i], loose[i + random.Index(static_cast<int>(loose.size()) - i)]);
    for (MovedVolume& volume : mover.Move(loose[i])) volumes.push_back(std::move(volume));
  }
  return volumes;
}

}  // namespace isthmus::simulation
