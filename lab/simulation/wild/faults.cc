#include "lab/simulation/wild/faults.h"

#include <absl/strings/str_format.h>

#include <cmath>
#include <numbers>

#include "core/geometry/angles.h"

namespace isthmus::simulation::wild {
namespace {

// Nothing in half of all drives; else mostly little.
double Strength(double most, Random& random) {
  const bool there = random.Chance(0.5);
  const double share = random.Unit();
  return there ? most * share * share : 0;
}

// Shades: the person who carries the sensor, a mast, a load.
void AddShades(const Carrier& carrier, Random& random, Effects* effects) {
  const auto any = [&] { return static_cast<float>(random.Uniform(-1, 1) * std::numbers::pi); };
  if (carrier.gait == Gait::kHand && carrier.height_m < 1.7) {
    const auto half = static_cast<float>(random.Uniform(20, 40) * kRadPerDeg);
    effects->shades.push_back({any(), half, 1.2f, static_cast<float>(random.Uniform(0.3, 0.7))});
  } else if (random.Chance(0.3)) {
    for (int i = 1 + random.Index(3); i > 0; --i) {
      const auto half = static_cast<float>(random.Uniform(0.5, 15) * kRadPerDeg);
      const auto highest = random.Chance(0.5) ? 1.5f : -0.1f;
      const auto range = static_cast<float>(random.Uniform(0, 1.5));
      effects->shades.push_back({any(), half, highest, range < 0.3f ? 0 : range});
    }
  }
}

}  // namespace

Faults DrawFaults(const Carrier& carrier, Random& random) {
  Faults faults;
  Noise& noise = faults.noise;
  noise.range_sigma_m = random.Uniform(0.005, 0.035);
  noise.dropout = random.Chance(0.7) ? 0.005 : random.Uniform(0, 0.1);
  noise.min_strength = random.Uniform(6, 20);
  Effects& effects = faults.effects;
  effects.rain = Strength(0.05, random);
  effects.dust = Strength(0.5, random);
  effects.foliage = random.Uniform(0, 0.7);
  effects.glass = random.Uniform(0.05, 1);
  effects.blooming_rad = Strength(2 * kRadPerDeg, random);
  effects.mixed = random.Uniform(0, 0.8);
  effects.packet_loss = random.Chance(0.6) ? 0 : Strength(0.05, random);
  effects.ring_range_sigma_m = Strength(0.03, random);
  effects.ring_angle_sigma_rad = Strength(0.12 * kRadPerDeg, random);
  effects.stamp_jitter_s = Strength(0.01, random);
  effects.clock_drift = (random.Chance(0.5) ? 1 : -1) * Strength(2e-4, random);
  AddShades(carrier, random, &effects);
  const auto tell = [&faults](double value, double from, const char* name) {
    if (value > from) absl::StrAppendFormat(&faults.about, ", %s %.2g", name, value);
  };
  tell(effects.rain, 0, "rain");
  tell(effects.dust, 0, "dust");
  tell(effects.packet_loss, 0, "packet loss");
  tell(effects.ring_range_sigma_m, 0.005, "rings m");
  tell(effects.ring_angle_sigma_rad / kRadPerDeg, 0.02, "rings deg");
  tell(effects.stamp_jitter_s, 0.001, "jitter s");
  tell(static_cast<double>(effects.shades.size()), 0, "shades");
  return faults;
}

}  // namespace isthmus::simulation::wild
