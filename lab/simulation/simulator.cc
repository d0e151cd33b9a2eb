#include "lab/simulation/simulator.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "lab/simulation/random.h"
#include "lab/simulation/wild/wild.h"
#include "lab/simulation/worlds/cars.h"
#include "lab/simulation/worlds/walkers.h"

namespace isthmus::simulation {
namespace {

// A pose in the form that is cheap to apply to many firings.
struct Frame {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d position;

  explicit Frame(const Pose& pose)
      : rotation(pose.RotationMatrix()), position(pose.translation()) {}
};

absl::Status Check(const Options& options) {
  const auto bad = [](const auto&... text) {
    return absl::InvalidArgumentError(absl::StrCat("simulation: ", text...));
  };
  if (options.robots < 1 || options.robots > 100) {
    return bad("robots must be 1 to 100, not ", options.robots);
  }
  if (!(options.seconds >= 0.1 && options.seconds <= 86400)) {
    return bad("seconds must be 0.1 to 86400, not ", options.seconds);
  }
  if (options.walkers < 0 || options.walkers > 1000) {
    return bad("walkers must be 0 to 1000, not ", options.walkers);
  }
  if (options.cars < 0 || options.cars > 100) {
    return bad("cars must be 0 to 100, not ", options.cars);
  }
  if (options.parked < 0 || options.parked > 100) {
    return bad("parked cars must be 0 to 100, not ", options.parked);
  }
  if (options.day < 1 || options.day > 365) {
    return bad("the day must be 1 to 365, not ", options.day);
  }
  if (options.moved != 0 && options.day == 1) {
    return bad("nothing has moved on day 1; choose --day 2");
  }
  const Noise& noise = options.noise;
  if (!(noise.range_sigma_m >= 0 && noise.range_sigma_m < 10)) {
    return bad("range noise must be 0 to 10 m, not ", noise.range_sigma_m);
  }
  if (!(noise.dropout >= 0 && noise.dropout <= 1)) {
    return bad("dropout must be 0 to 1, not ", noise.dropout);
  }
  if (!(noise.min_strength >= 0)) {
    return bad("minimum strength must not be negative, but is ", noise.min_strength);
  }
  return absl::OkStatus();
}

uint64_t DaySeed(const Options& options) {
  if (options.day == 1) return options.seed;
  return Random(options.seed, 0x9A, static_cast<uint64_t>(options.day)).Next();
}

absl::StatusOr<std::unique_ptr<Simulator>> CreateWild(const Options& options, int robot) {
  if (options.day != 1) {
    return absl::InvalidArgumentError("simulation: wild worlds have one day; choose no --day");
  }
  if (options.walkers != 0 || options.cars != 0 || options.parked != 0) {
    return absl::InvalidArgumentError(
        "simulation: people and cars are drawn with a wild world; choose neither walkers nor cars");
  }
  const std::string kind = options.world.substr(kWildPrefix.size());
  auto drive =
      options.robots == 1
          ? DrawWildDrive(options.seed, {kind, options.sensor, options.seconds, options.truth})
          : DrawWildTeamDrive(options.seed,
                              {.kind = kind,
                               .sensor = options.sensor,
                               .robots = options.robots,
                               .seconds = options.seconds,
                               .first_day = true,
                               .truth = options.truth},
                              robot);
  if (!drive.ok()) return drive.status();
  return std::move(drive->simulator);
}

// Cars that drive, and cars that stand.
std::vector<Motion> MakeCars(const World& world, const Options& options) {
  std::vector<Motion> cars = MakeTraffic(world, options.cars, options.seconds, DaySeed(options));
  for (Motion& car : MakeParked(world, options.parked, options.seconds, DaySeed(options))) {
    cars.push_back(std::move(car));
  }
  return cars;
}

float Intensity(const Hit& hit, double brightness, Truth truth) {
  if (truth == Truth::kClass) return static_cast<float>(hit.surface);
  if (truth == Truth::kMoving && hit.moves) return 255;
  const double most = truth == Truth::kMoving ? 254 : 255;
  return static_cast<float>(std::min(most, std::round(std::clamp(brightness, 1.0, 255.0))));
}

// Adds what was measured, if anything, to the scan.
void Measure(const Lidar& lidar, const Firing& firing, const Hit& hit, const Options& options,
             double range_offset_m, Random& random, Scan& scan) {
  if (hit.range_m < 0) return;
  const Noise& noise = options.noise;
  const double range = hit.range_m + range_offset_m + noise.range_sigma_m * random.Normal();
  if (range < lidar.min_range_m || range > lidar.max_range_m) return;
  const double brightness = Reflectivity(hit.material) * hit.cosine;
  const double share = range / lidar.max_range_m;
  const double strength = brightness / (share * share);
  const double lost = std::max(0.0, 1 - strength / std::max(noise.min_strength, 1e-9));
  if (random.Chance(noise.dropout + lost)) return;
  const Eigen::Vector3f at = static_cast<float>(range) * firing.direction;
  ScanPoint point;
  point.x = at.x();
  point.y = at.y();
  point.z = at.z();
  point.intensity = Intensity(hit, brightness, options.truth);
  point.time = static_cast<float>(std::min(0.0, firing.time_s - lidar.period_s));
  point.ring = firing.ring;
  scan.points.push_back(point);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Simulator>> Simulator::Create(const Options& options) {
  if (absl::Status status = Check(options); !status.ok()) return status;
  if (absl::StartsWith(options.world, kWildPrefix)) {
    if (options.robots == 1) return CreateWild(options, 0);
    return absl::InvalidArgumentError(
        "simulation: only one robot can be simulated in a wild world here; choose --robots 1");
  }
  absl::StatusOr<Lidar> lidar = MakeLidar(options.sensor);
  if (!lidar.ok()) return lidar.status();
  absl::StatusOr<World> world = MakeWorld(options.world, options.seed);
  if (!world.ok()) return world.status();
  if (options.cars + options.parked > 0 && !world->has_streets) {
    return absl::InvalidArgumentError(
        absl::StrCat("simulation: there are no streets for cars in the world ", options.world,
                     "; choose campus, or no cars"));
  }
  Random furniture(options.seed, 0x9B, static_cast<uint64_t>(options.day));
  auto moved = MoveFurniture(options.moved, furniture, &*world);
  if (!moved.ok()) return moved.status();
  auto motions = MakeRoutes(*world, options.robots, options.seconds, DaySeed(options));
  if (!motions.ok()) return motions.status();
  auto simulator = std::make_unique<Simulator>(*std::move(world), *std::move(motions),
                                               *std::move(lidar), options);
  simulator->moved_ = *std::move(moved);
  return simulator;
}

absl::StatusOr<std::vector<std::unique_ptr<Simulator>>> Simulator::CreateTeam(
    const Options& options) {
  if (absl::Status status = Check(options); !status.ok()) return status;
  const bool is_wild = absl::StartsWith(options.world, kWildPrefix);
  std::vector<std::unique_ptr<Simulator>> team;
  for (int robot = 0; robot < (is_wild ? options.robots : 1); ++robot) {
    auto simulator = is_wild ? CreateWild(options, robot) : Create(options);
    if (!simulator.ok()) return simulator.status();
    team.push_back(*std::move(simulator));
  }
  return team;
}

Simulator::Simulator(World world, std::vector<Motion> motions, Lidar lidar, const Options& options)
    : Simulator(world, std::move(motions),
                {MakeWalks(world, options.walkers, options.seconds, DaySeed(options)),
                 MakeCars(world, options)},
                std::move(lidar), options) {}

Simulator::Simulator(World world, std::vector<Motion> motions, Actors actors, Lidar lidar,
                     const Options& options)
    : options_(options),
      day_seed_(DaySeed(options)),
      world_(std::move(world)),
      motions_(std::move(motions)),
      actors_(std::move(actors)),
      lidar_(std::move(lidar)),
      miscalibration_(options.effects, lidar_, options.seed),
      caster_(world_.mesh) {}

int Simulator::scan_count() const {
  return static_cast<int>(options_.seconds / lidar_.period_s + 1e-6);
}

std::vector<Ray> Simulator::Aim(int robot, double begin_s, std::span<const Firing> firings) const {
  const size_t groups = firings.size() / lidar_.lasers;
  const double group_s = lidar_.period_s / static_cast<double>(groups);
  std::vector<Ray> rays(firings.size());
  Frame from(motions_[robot](begin_s));
  for (size_t group = 0; group < groups; ++group) {
    // Exact poses at the ends of each group; between them, some 50 us, motion is linear.
    const double group_begin = static_cast<double>(group) * group_s;
    const Frame to(motions_[robot](begin_s + group_begin + group_s));
    for (size_t i = group * lidar_.lasers; i < (group + 1) * lidar_.lasers; ++i) {
      const double f = (firings[i].time_s - group_begin) / group_s;
      const Eigen::Matrix3d rotation = from.rotation + f * (to.rotation - from.rotation);
      rays[i].origin = (from.position + f * (to.position - from.position)).cast<float>();
      rays[i].direction = rotation.cast<float>() * miscalibration_.Direction(firings[i]);
    }
    from = to;
  }
  return rays;
}

Scan Simulator::MakeScan(int robot, int index) const {
  Scan scan;
  scan.sequence = static_cast<uint64_t>(index) + 1;
  scan.end_stamp_ns = Stamp(robot, index);
  scan.has_ring = lidar_.has_rings;
  scan.has_time = true;
  const std::vector<Firing> firings = AtScan(lidar_, index).firings;
  scan.points.reserve(firings.size());
  Random random(day_seed_, static_cast<uint64_t>(robot) + 1, scan.sequence);

  const double begin = index * lidar_.period_s;
  const Walkers walkers(actors_.walks, begin, begin + lidar_.period_s);
  const Cars cars(actors_.cars, begin, begin + lidar_.period_s);
  const auto max_range = static_cast<float>(lidar_.max_range_m);
  const auto occlude = [&](const Ray& ray, size_t firing, Hit& hit) {
    const double fraction = firings[firing].time_s / lidar_.period_s;
    walkers.Occlude(ray, fraction, max_range, hit);
    cars.Occlude(ray, fraction, max_range, hit);
  };
  const std::vector<Ray> rays = Aim(robot, begin, firings);
  std::vector<Hit> hits(rays.size());
  for (size_t group = 0; group < rays.size(); group += lidar_.lasers) {
    caster_.Cast({&rays[group], lidar_.lasers}, max_range, {&hits[group], lidar_.lasers});
  }
  for (size_t i = 0; i < rays.size(); ++i) occlude(rays[i], i, hits[i]);
  if (options_.effects.Disturb()) {
    const Trace trace = [&](std::span<const Ray> onward, std::span<const size_t> which,
                            std::span<Hit> found) {
      caster_.Cast(onward, max_range, found);
      for (size_t i = 0; i < onward.size(); ++i) occlude(onward[i], which[i], found[i]);
    };
    Random chance(day_seed_, 0x84 + static_cast<uint64_t>(robot), scan.sequence);
    Disturb(options_.effects, {firings, lidar_.lasers, rays, hits, begin}, trace, chance);
  }
  for (size_t i = 0; i < hits.size(); ++i) {
    Measure(lidar_, firings[i], hits[i], options_, miscalibration_.RangeOffset(firings[i]), random,
            scan);
  }
  return scan;
}

int64_t Simulator::Stamp(int robot, int index) const {
  const StampedPose truth = Truth(robot, index);
  const double end = (index + 1) * lidar_.period_s;
  return truth.stamp_ns + std::llround(StampError(options_.effects, end, day_seed_, index) * 1e9);
}

StampedPose Simulator::Truth(int robot, int index) const {
  const double end = (index + 1) * lidar_.period_s;
  constexpr int64_t kDayNs = int64_t{86400} * 1'000'000'000;
  return {options_.start_stamp_ns + (options_.day - 1) * kDayNs + std::llround(end * 1e9),
          motions_[robot](end)};
}

Trajectory Simulator::Truth(int robot) const {
  Trajectory truth;
  for (int i = 0; i < scan_count(); ++i) truth.push_back(Truth(robot, i));
  return truth;
}

}  // namespace isthmus::simulation
