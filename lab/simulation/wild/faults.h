// Faults of a wild drive's measurements.
#pragma once

#include <string>

#include "lab/simulation/random.h"
#include "lab/simulation/simulator.h"
#include "lab/simulation/wild/carrier.h"

namespace isthmus::simulation::wild {

struct Faults {
  Noise noise;
  Effects effects;
  std::string about;  // The faults that are there: ", rain 0.02, ...".
};

// Each effect by itself: often none or little, sometimes much, never more than real sensors show.
Faults DrawFaults(const Carrier& carrier, Random& random);

}  // namespace isthmus::simulation::wild
