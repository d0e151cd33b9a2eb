#include "server/matching/pairs/anchor_prior.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "core/geometry/angles.h"
#include "server/matching/pairs/limits.h"

namespace isthmus::matching {
namespace {

using Complex = std::complex<double>;

// 0 for what is not known, or so vaguely that it would only say: not on this site.
double Weight(double sigma, double least, double vague = std::numeric_limits<double>::infinity()) {
  return sigma > 0 && sigma < vague ? 1 / std::max(sigma * sigma, least * least) : 0;
}

Complex Plan(const Eigen::Vector3d& p) { return {p.x(), p.y()}; }

// Logarithm of the modified Bessel function of the first kind, order 0 (Abramowitz and Stegun,
// 9.7.1, where it would overflow).
double LogBessel0(double x) {
  if (x < 100) return std::log(std::cyl_bessel_i(0.0, x));
  return x - 0.5 * std::log(2 * M_PI * x) + std::log1p(1 / (8 * x));
}

}  // namespace

// The likelihood of a heading t, with ties in plan normal, headings von Mises distributed, and the
// place integrated out: exp(turn.real * cos t + turn.imag * sin t - misfit).
struct AnchorPrior::Fit {
  double xy = 0, z = 0;            // Sums of weights.
  Complex level = 0, site = 0;     // Weighted means of the ties, in plan, ...
  double level_z = 0, site_z = 0;  // ... and height.
  Complex turn = 0;
  double misfit = 0;
  double known = 0;  // Number of coordinates in plan.

  // The ties' variance over the variance that they claim (a posteriori variance of unit weight).
  double Variance() const { return known > 3 ? 2 * (misfit - std::abs(turn)) / (known - 3) : 0; }
  double heading() const { return std::arg(turn); }
  // Log evidence, but for what does not depend on how the maps lie.
  double LogEvidence() const {
    double log = LogBessel0(std::abs(turn)) - misfit;
    if (xy > 0) log += std::log(2 * M_PI / (xy * kSiteM * kSiteM));
    if (z > 0) log += 0.5 * std::log(2 * M_PI / z) - std::log(kSiteHeightM);
    return log;
  }
};

AnchorPrior::AnchorPrior(const PreparedMap& a, const PreparedMap& b,
                         const std::vector<Anchor>& anchors)
    : T_level_a_(a.T_level_odom()), T_level_b_(b.T_level_odom()) {
  const auto take = [&](const PreparedMap& map, std::vector<Tie>* ties, std::vector<Pose>* poses) {
    const auto& submaps = map.session_map().submaps;
    for (size_t k = 0; k < submaps.size(); ++k) {
      poses->push_back(submaps[k]->T_odom_submap);
      const SubmapId& id = submaps[k]->id;
      const auto anchor = std::lower_bound(
          anchors.begin(), anchors.end(), id,
          [](const Anchor& one, const SubmapId& other) { return one.submap < other; });
      if (anchor == anchors.end() || anchor->submap != id) continue;
      const Tie tie{k,
                    anchor->T_map_submap.translation(),
                    anchor->T_map_submap.Yaw(),
                    Weight(anchor->sigma_xy_m, kLeastSigmaM, kVagueM),
                    Weight(anchor->sigma_z_m, kLeastSigmaM, kVagueHeightM),
                    Weight(anchor->sigma_deg * kRadPerDeg, kLeastSigmaRad)};
      if (tie.xy + tie.z + tie.turn > 0) ties->push_back(tie);
    }
  };
  take(a, &of_a_, &in_odom_.a);
  take(b, &of_b_, &in_odom_.b);
  if (empty()) return;
  // Odometry drifts between a tie and the rest of its map, where the other may meet it: the tie is
  // so much less certain. Ties that fit worse than that among themselves are worth the less.
  const auto widen = [](const std::vector<Pose>& odom, std::vector<Tie>* ties) {
    for (Tie& tie : *ties) {
      double far = 0;
      for (const Pose& pose : odom) {
        far += (pose.translation() - odom[tie.submap].translation()).norm();
      }
      far /= static_cast<double>(odom.size());
      const auto add = [&](double sigma, double* weight) {
        if (*weight > 0) *weight = 1 / (1 / *weight + sigma * sigma);
      };
      add(kAnchoredDrift * far, &tie.xy);
      add(kAnchoredDrift * far, &tie.z);
      add(kAnchoredTurn * far, &tie.turn);
    }
  };
  widen(in_odom_.a, &of_a_);
  widen(in_odom_.b, &of_b_);
  const auto weigh = [](std::vector<Tie>* ties, const Pose& T_level,
                        const std::vector<Pose>& odom) {
    std::vector<Placed> placed;
    Place(*ties, T_level, odom, &placed);
    const double worse = std::max(1.0, FitTo(placed).Variance());
    for (Tie& tie : *ties) {
      for (double* weight : {&tie.xy, &tie.z, &tie.turn}) *weight /= worse;
    }
    return FitTo(placed);
  };
  const Fit a_alone = weigh(&of_a_, T_level_a_, in_odom_.a);
  const Fit b_alone = weigh(&of_b_, T_level_b_, in_odom_.b);
  alone_ = a_alone.LogEvidence() + b_alone.LogEvidence();
  if (a_alone.xy > 0 && b_alone.xy > 0) {
    guess_sigma_m_ = std::sqrt(1 / a_alone.xy + 1 / b_alone.xy);
  }
}

void AnchorPrior::Place(const std::vector<Tie>& ties, const Pose& T_level_map,
                        const std::vector<Pose>& poses, std::vector<Placed>* placed) {
  for (const Tie& tie : ties) placed->push_back({&tie, T_level_map * poses[tie.submap]});
}

AnchorPrior::Fit AnchorPrior::FitTo(const std::vector<Placed>& placed) {
  Fit fit;
  for (const auto& [tie, T] : placed) {
    fit.xy += tie->xy;
    fit.known += tie->xy > 0 ? 2 : 0;
    fit.z += tie->z;
    fit.level += tie->xy * Plan(T.translation());
    fit.site += tie->xy * Plan(tie->T_site);
    fit.level_z += tie->z * T.translation().z();
    fit.site_z += tie->z * tie->T_site.z();
  }
  if (fit.xy > 0) {
    fit.level /= fit.xy;
    fit.site /= fit.xy;
  }
  if (fit.z > 0) {
    fit.level_z /= fit.z;
    fit.site_z /= fit.z;
  }
  for (const auto& [tie, T] : placed) {
    const Complex level = Plan(T.translation()) - fit.level, site = Plan(tie->T_site) - fit.site;
    const double up = (tie->T_site.z() - fit.site_z) - (T.translation().z() - fit.level_z);
    fit.turn += tie->xy * std::conj(level) * site + std::polar(tie->turn, tie->heading - T.Yaw());
    fit.misfit += 0.5 * (tie->xy * (std::norm(level) + std::norm(site)) + tie->z * up * up);
  }
  return fit;
}

double AnchorPrior::LogOdds(const MapPoses& poses, const Pose& T_a_a) const {
  if (empty()) return 0;
  std::vector<Placed> placed;
  Place(of_a_, T_level_a_, poses.a, &placed);
  Place(of_b_, T_level_a_ * T_a_a, poses.b, &placed);
  return FitTo(placed).LogEvidence() - alone_;
}

std::optional<Pose> AnchorPrior::Guess() const {
  if (empty()) return std::nullopt;
  std::vector<Placed> placed_a, placed_b;
  Place(of_a_, T_level_a_, in_odom_.a, &placed_a);
  Place(of_b_, T_level_b_, in_odom_.b, &placed_b);
  const auto site_of = [](const Fit& fit) {
    const Complex shift = fit.site - std::polar(1.0, fit.heading()) * fit.level;
    return Pose::FromXyzRpy(shift.real(), shift.imag(), fit.site_z - fit.level_z, 0, 0,
                            fit.heading());
  };
  const Fit a = FitTo(placed_a), b = FitTo(placed_b);
  for (const Fit* fit : {&a, &b}) {
    if (fit->xy == 0 || std::abs(fit->turn) < kKnownHeading) return std::nullopt;
  }
  const Pose T_site_a = site_of(a) * T_level_a_;
  Pose T_site_b = site_of(b) * T_level_b_;
  if (a.z == 0 || b.z == 0) {
    double nearest = std::numeric_limits<double>::infinity(), height = 0;
    for (const Pose& at_b : in_odom_.b) {
      for (const Pose& at_a : in_odom_.a) {
        const Eigen::Vector3d gap = T_site_a * at_a.translation() - T_site_b * at_b.translation();
        if (gap.head<2>().norm() >= nearest) continue;
        nearest = gap.head<2>().norm();
        height = gap.z();
      }
    }
    T_site_b = Pose(Eigen::Vector3d(0, 0, height)) * T_site_b;
  }
  return T_site_a.Inverse() * T_site_b;
}

}  // namespace isthmus::matching
