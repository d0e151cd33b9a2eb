#include "lab/simulation/worlds/world.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <cmath>

#include "lab/simulation/worlds/builders.h"

namespace isthmus::simulation {

double Ground::Height(double x, double y) const {
  double z = 0;
  for (const Wave& w : waves) z += w.amplitude * std::sin(w.kx * x + w.ky * y + w.phase);
  return z;
}

std::vector<std::string> WorldNames() {
  return {"museum", "warehouse",   "campus",      "campus_wide", "corridor",
          "twins",  "twins_large", "twins_wings", "twins_joined"};
}

absl::StatusOr<World> MakeWorld(const std::string& name, uint64_t seed) {
  World world;
  if (name == "museum") {
    world = MakeMuseum(seed);
  } else if (name == "warehouse") {
    world = MakeWarehouse(seed);
  } else if (name == "campus" || name == "campus_wide") {
    world = MakeCampus(seed, name == "campus" ? 5 : 12);
  } else if (name == "corridor") {
    world = MakeCorridor(seed);
  } else if (name == "twins" || name == "twins_joined") {
    world = MakeTwins(seed, name == "twins_joined");
  } else if (name == "twins_large" || name == "twins_wings") {
    world = MakeLargeTwins(seed, name == "twins_wings");
  } else {
    return absl::InvalidArgumentError(
        absl::StrCat("no world is called \"", name, "\"; choose one of ",
                     absl::StrJoin(WorldNames(), ", "), ", or a wild one such as wild-flat"));
  }
  world.name = name;
  return world;
}

}  // namespace isthmus::simulation
