// Composition of a museum that two robots walked for a minute each: the sizes of the paper's
// experiment, whose global map took 296 ms.
#include <benchmark/benchmark.h>

#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "server/composition/composer.h"
#include "server/composition/occupancy/kept_occupancy.h"

namespace isthmus::composition {
namespace {

// Submaps with their points.
struct World {
  std::vector<PlacedSubmap> placed;
  std::map<SubmapId, std::shared_ptr<const Submap>> content;

  void Add(std::shared_ptr<const Submap> submap) {
    placed.push_back({std::make_shared<SubmapInfo>(Summarize(*submap)), 0, Pose()});
    content[submap->id] = std::move(submap);
  }
  SubmapReader reader() const {
    return [this](const SubmapId& id) { return content.at(id); };
  }
};

constexpr int kRobots = 2;
constexpr int kSubmapsPerRobot = 15;
constexpr int kKeyframesPerSubmap = 5;
constexpr int kPointsPerKeyframe = 10000;  // A thinned VLP-16 scan.
constexpr int kPointsOutdoors = 7400;      // Fewer points of farther surfaces share a voxel.
constexpr double kHallX = 40, kHallY = 25, kHallZ = 5;

// The point where a ray from `origin` meets the walls, floor or ceiling of a room of which the
// origin is in.
Eigen::Vector3d HitRoom(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                        const Box& room) {
  double range = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0) continue;
    const double face = direction[axis] > 0 ? room.max[axis] : room.min[axis];
    range = std::min(range, (face - origin[axis]) / direction[axis]);
  }
  return origin + range * direction;
}

// The hall is a grid of rooms; a sensor sees the one that it is in.
Box RoomOf(const Eigen::Vector3d& p) {
  const double edge_x = kHallX / 4, edge_y = kHallY / 2;
  Box room;
  room.min = {std::floor(p.x() / edge_x) * edge_x, std::floor(p.y() / edge_y) * edge_y, 0};
  room.max = room.min + Eigen::Vector3d(edge_x, edge_y, kHallZ);
  return room;
}

// A look around with 16 lasers, 2 cm noise, in a room that the sensor is in.
void AddKeyframe(const Eigen::Vector3d& sensor, const Box& room, int points, std::mt19937* rng,
                 Submap* submap) {
  std::normal_distribution<double> noise(0, 0.02);
  const auto keyframe = static_cast<uint16_t>(submap->keyframes.size());
  submap->keyframes.push_back({.T_submap_sensor = Pose(sensor)});
  for (int i = 0; i < points; ++i) {
    const double azimuth = 2 * std::numbers::pi * (i / 16) / (points / 16.);
    const double elevation = (-15 + 2 * (i % 16)) * std::numbers::pi / 180;
    const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth),
                              std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
    const Eigen::Vector3d p = HitRoom(sensor, ray, room) + noise(*rng) * ray;
    submap->points.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()),
                              static_cast<float>(p.z()), 1, keyframe});
  }
}

World Museum() {
  std::mt19937 rng(1);
  World world;
  const int steps = kSubmapsPerRobot * kKeyframesPerSubmap;
  for (int robot = 0; robot < kRobots; ++robot) {
    const std::string name = robot == 0 ? "alice" : "bob";
    for (int s = 0; s < kSubmapsPerRobot; ++s) {
      auto submap = std::make_shared<Submap>();
      submap->id = {SessionId(name + "-1"), static_cast<uint32_t>(s)};
      submap->robot = RobotId(name);
      for (int k = 0; k < kKeyframesPerSubmap; ++k) {
        const double turn =
            2 * std::numbers::pi * (s * kKeyframesPerSubmap + k + robot * steps / 2) / steps;
        const Eigen::Vector3d sensor(kHallX / 2 + .4 * kHallX * std::cos(turn) + .01,
                                     kHallY / 2 + .35 * kHallY * std::sin(turn) + .01, 0.6);
        AddKeyframe(sensor, RoomOf(sensor), kPointsPerKeyframe, &rng, submap.get());
      }
      world.Add(submap);
    }
  }
  return world;
}

void ReportSize(const World& world, uint64_t map_points, benchmark::State* state) {
  double points = 0;
  for (const PlacedSubmap& p : world.placed) points += static_cast<double>(p.submap->point_count);
  state->counters["submap_points"] = points;
  state->counters["map_points"] = static_cast<double>(map_points);
}

// Everything anew, the submaps' own thinning included: what a restart costs.
void BM_ComposeFromScratch(benchmark::State& state) {
  const World world = Museum();
  uint64_t map_points = 0;
  for (auto _ : state) {
    Composer composer({});
    map_points = composer.Compose(1, world.placed, world.reader()).value()->point_count(0);
  }
  ReportSize(world, map_points, &state);
}
BENCHMARK(BM_ComposeFromScratch)->Unit(benchmark::kMillisecond);

// One robot's transform changed: half the submaps move, every tile is remade.
void BM_ComposeAfterMove(benchmark::State& state) {
  World world = Museum();
  Composer composer({});
  int64_t revision = 0;
  composer.Compose(++revision, world.placed, world.reader()).value();
  uint64_t map_points = 0;
  for (auto _ : state) {
    const Pose T_map_submap(Eigen::Vector3d(revision % 2 ? 0.1 : 0, 0, 0));
    for (size_t i = world.placed.size() / 2; i < world.placed.size(); ++i)
      world.placed[i].T_map_submap = T_map_submap;
    map_points = composer.Compose(++revision, world.placed, world.reader()).value()->point_count(0);
  }
  ReportSize(world, map_points, &state);
}
BENCHMARK(BM_ComposeAfterMove)->Unit(benchmark::kMillisecond);

// Five hundred submaps, 15 m each, in rows 30 m apart through halls of 60 x 60 m: two rows see each
// hall, as two streets see a square. `keyframes` of a submap: 15 are those of a car or a robot
// outdoors, 110,000 points in all.
World Streets(int keyframes) {
  constexpr int kSubmaps = 500, kPerRow = 40;
  constexpr double kLength = 15, kRow = 30, kHall = 60;
  std::mt19937 rng(2);
  World world;
  for (int s = 0; s < kSubmaps; ++s) {
    auto submap = std::make_shared<Submap>();
    submap->id = {SessionId("alice-1"), static_cast<uint32_t>(s)};
    submap->robot = RobotId("alice");
    const Eigen::Vector3d begin(s % kPerRow * kLength, (s / kPerRow + 0.5) * kRow, 1.8);
    for (int k = 0; k < keyframes; ++k) {
      const Eigen::Vector3d sensor = begin + Eigen::Vector3d((k + 0.5) * kLength / keyframes, 0, 0);
      Box hall;
      hall.min = {std::floor(sensor.x() / kHall) * kHall, std::floor(sensor.y() / kHall) * kHall,
                  0};
      hall.max = hall.min + Eigen::Vector3d(kHall, kHall, 12);
      AddKeyframe(sensor, hall, kPointsOutdoors, &rng, submap.get());
    }
    world.Add(submap);
  }
  return world;
}

// A loop was closed: twenty submaps in a row move, by 0.5 m and back.
void BM_ComposeAfterClosure(benchmark::State& state) {
  World world = Streets(static_cast<int>(state.range(0)));
  Composer composer({});
  int64_t revision = 0;
  composer.Compose(++revision, world.placed, world.reader()).value();
  state.counters["all_tiles"] = composer.last_tiles_remade();
  uint64_t map_points = 0;
  for (auto _ : state) {
    const Pose T_map_submap(Eigen::Vector3d(0, revision % 2 ? 0.5 : 0, 0));
    for (size_t i = 210; i < 230; ++i) world.placed[i].T_map_submap = T_map_submap;
    map_points = composer.Compose(++revision, world.placed, world.reader()).value()->point_count(0);
  }
  state.counters["tiles_remade"] = composer.last_tiles_remade();
  ReportSize(world, map_points, &state);
}
BENCHMARK(BM_ComposeAfterClosure)->Arg(5)->Arg(15)->Unit(benchmark::kMillisecond);

// The usual work of the fast loop: one submap came.
void BM_ComposeOneMoreSubmap(benchmark::State& state) {
  const World world = Museum();
  const std::vector<PlacedSubmap> before(world.placed.begin(), world.placed.end() - 1);
  uint64_t map_points = 0;
  Composer composer({});
  for (auto _ : state) {
    state.PauseTiming();
    composer.Compose(1, before, world.reader()).value();
    state.ResumeTiming();
    map_points = composer.Compose(2, world.placed, world.reader()).value()->point_count(0);
  }
  ReportSize(world, map_points, &state);
}
BENCHMARK(BM_ComposeOneMoreSubmap)->Unit(benchmark::kMillisecond);

void BM_ReadBox(benchmark::State& state) {
  Composer composer({});
  const World world = Museum();
  const auto map = composer.Compose(1, world.placed, world.reader()).value();
  Region region;
  region.box.Extend(Eigen::Vector3d(5, 5, 0));
  region.box.Extend(Eigen::Vector3d(15, 15, 5));
  region.resolution_m = state.range(0) * 0.1;
  size_t points = 0;
  for (auto _ : state) {
    points = 0;
    const absl::Status status = map->Read(region, 10000, [&](const std::vector<MapPoint>& chunk) {
      points += chunk.size();
      return true;
    });
    if (!status.ok()) state.SkipWithError(status.ToString().c_str());
  }
  state.counters["points"] = static_cast<double>(points);
}
BENCHMARK(BM_ReadBox)->Arg(0)->Arg(5)->Unit(benchmark::kMillisecond);

void BM_Occupancy(benchmark::State& state) {
  const World world = Museum();
  OccupancyOptions options;
  options.resolution_m = state.range(0) * 0.01;
  size_t bytes = 0;
  for (auto _ : state) {
    bytes = WriteOccupancy(world.placed, world.reader(), 0, OccupancyFormat::kBinary, options)
                .value()
                .size();
  }
  state.counters["file_bytes"] = static_cast<double>(bytes);
}
BENCHMARK(BM_Occupancy)->Arg(20)->Arg(10)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace isthmus::composition
