#include "lab/simulation/wild/further.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "lab/simulation/wild/footing.h"

namespace isthmus::simulation::wild {
namespace {

constexpr double kRoundM = 0.4;
constexpr double kTurnRadps = 0.7;  // Shaking and spline leave it below 0.8.
constexpr double kLeastM = 0.3;     // A shorter way is not worth setting out for.
constexpr double kStandS = 0.5;     // At rest before it turns.

// Slows down by 3 x^2 - 2 x^3, so that it goes half as far as it would.
Motion Braked(const Motion& base, double from_s, double braking_s) {
  return [=](double t) {
    if (t <= from_s + kTickS) return base(t);
    const double x = std::min((t - from_s) / braking_s, 1.0);
    return base(from_s + braking_s * (x - x * x * x + x * x * x * x / 2));
  };
}

// Leaves out the points that it has come by while it braked for `braked_m`.
void DropPassed(const Eigen::Vector2d& at, double braked_m, std::vector<Eigen::Vector3d>* way) {
  constexpr double kBesideM = 0.5;
  const double farthest = 1.2 * braked_m + kBesideM;  // Along the way.
  const auto flat = [&](size_t i) -> Eigen::Vector2d { return (*way)[i].head<2>(); };
  double length = 0, nearest_m = 0;
  size_t nearest = 0;
  for (size_t i = 1; i < way->size(); ++i) {
    length += (flat(i) - flat(i - 1)).norm();
    if (length > farthest) break;
    if ((flat(i) - at).norm() >= (flat(nearest) - at).norm()) continue;
    nearest = i;
    nearest_m = length;
  }
  if (nearest + 1 < way->size()) {
    const Eigen::Vector2d on = (flat(nearest + 1) - flat(nearest)).normalized();
    const Eigen::Vector2d by = at - flat(nearest);
    const double along = on.dot(by), beside = on.x() * by.y() - on.y() * by.x();
    if (along > 0 && nearest_m + along < farthest && std::abs(beside) < kBesideM) ++nearest;
  }
  way->erase(way->begin(), way->begin() + static_cast<std::ptrdiff_t>(nearest));
}

// A path from `at` by the points, longer at both ends; without points that are near each other.
// Empty if nothing is left.
std::vector<Eigen::Vector3d> Corners(const Eigen::Vector3d& at,
                                     const std::vector<Eigen::Vector3d>& way) {
  std::vector<Eigen::Vector3d> corners{at};
  const auto flat = [&](const Eigen::Vector3d& p) { return Eigen::Vector3d(p.x(), p.y(), at.z()); };
  for (const Eigen::Vector3d& point : way) {
    const double apart = (flat(point) - corners.back()).norm();
    if (apart >= (corners.size() == 1 ? 2 * kRoundM : kRoundM)) corners.push_back(flat(point));
  }
  if (corners.size() < 2) return {};
  if (corners.size() > 2) corners.back() = flat(way.back());
  const auto beyond = [](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    return Eigen::Vector3d(to + 2 * kRoundM * (to - from).normalized());
  };
  corners.push_back(beyond(corners.end()[-2], corners.back()));
  corners.insert(corners.begin(), beyond(corners[1], corners[0]));
  return corners;
}

// The place on the last metres of a path that is nearest to a point.
double EndOf(const Path& path, const Eigen::Vector3d& point) {
  double end = path.length(), least = 1e9;
  for (double s = path.length(); s > std::max(0.0, path.length() - 4 * kRoundM); s -= 0.02) {
    const double away = (path.At(s).position - point).head<2>().norm();
    if (away >= least) continue;
    least = away;
    end = s;
  }
  return end;
}

// From one pose to the other, by t^3 (10 - 15 t + 6 t^2), which is at rest at both ends.
Motion Turn(const Pose& from, const Pose& to, double begin_s, double seconds) {
  return [=](double t) {
    const double x = std::clamp((t - begin_s) / seconds, 0.0, 1.0);
    const double f = x * x * x * (10 - 15 * x + 6 * x * x);
    return Pose(from.rotation().slerp(f, to.rotation()),
                from.translation() + f * (to.translation() - from.translation()));
  };
}

}  // namespace

Timetable::State StateOf(const Motion& base, double seconds) {
  constexpr double kStep = 0.02;
  const Eigen::Vector2d at = base(seconds).translation().head<2>();
  const double ahead = (base(seconds + kStep).translation().head<2>() - at).norm() / kStep;
  const double behind = (base(seconds - kStep).translation().head<2>() - at).norm() / kStep;
  return {0, (ahead + behind) / 2, (ahead - behind) / kStep};
}

double BrakingSeconds(const Motion& base, double from_s) {
  return std::clamp(0.6 * StateOf(base, from_s).speed_mps, 1.0, 4.0);
}

std::vector<Eigen::Vector3d> ToAndFro(const Path& path, double begin_m, double metres) {
  constexpr double kStep = 0.5, kEndsM = 3;
  std::vector<Eigen::Vector3d> way;
  double s = begin_m, step = kStep;
  for (double gone = 0; gone < metres; gone += kStep) {
    if (s + step > path.length() - kEndsM) step = -kStep;
    if (s + step < kEndsM) step = kStep;
    s += step;
    way.push_back(path.At(s).position);
  }
  return way;
}

LongerMotion GoOn(const Motion& base, double from_s, std::vector<Eigen::Vector3d> way,
                  const Carrier& carrier, const RayCaster& world, Random& random) {
  const double braking_s = BrakingSeconds(base, from_s);
  const Motion braked = Braked(base, from_s, braking_s);
  const double rest_s = from_s + braking_s + kStandS;
  const Pose rest = braked(rest_s);
  LongerMotion longer{braked, rest_s};
  longer.metres = (rest.translation() - base(from_s).translation()).head<2>().norm();
  if (way.empty()) return longer;
  DropPassed(rest.translation().head<2>(), longer.metres, &way);
  const auto corners = Corners(rest.translation(), way);
  if (corners.empty()) return longer;
  const auto path =
      std::make_shared<const Path>(OnGround(Path::Along(corners, kRoundM), carrier, world));
  const double begin_m = kRoundM - path->step_m(), wanted_m = EndOf(*path, corners.end()[-2]);
  const double end_m = FreeUntil(*path, begin_m, wanted_m, carrier, world);
  longer.blocked = end_m < wanted_m;
  if (end_m - begin_m < kLeastM) return longer;

  Carrier careful = carrier;
  careful.yaw_rate_radps = std::min(carrier.yaw_rate_radps, kTurnRadps);
  careful.under_way = false;
  careful.stop_every_m = 1e9;
  const Pose ahead = BaseOn(path->At(begin_m), carrier);
  const double turn = RotationAngle(rest.Inverse() * ahead);
  const double turn_s = std::max(1.0, 1.875 * turn / careful.yaw_rate_radps);
  const double set_out_s = rest_s + turn_s;
  const Timetable timetable(*path, careful, begin_m, 86400, random, end_m);
  longer.end_s = set_out_s + timetable.end_s();
  longer.metres += end_m - begin_m;
  longer.base = [=, turned = Turn(rest, ahead, rest_s, turn_s)](double t) {
    if (t < rest_s) return braked(t);
    if (t < set_out_s) return turned(t);
    return BaseOn(path->At(timetable.At(t - set_out_s).s), carrier);
  };
  return longer;
}

}  // namespace isthmus::simulation::wild
