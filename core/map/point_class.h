// The kinds of things that points of a map lie on.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string_view>

namespace isthmus {

// The numbers are stored and trained on: new classes come last.
enum class PointClass : uint8_t {
  kUnknown,     // Also what is nowhere: drops, dust, the carrier itself.
  kGround,      // All that one walks or drives on: floors, terrain, streets, kerbs, stairs, ramps.
  kCeiling,     // Ceilings and roofs, the lower side of floors, the upper side of tunnels.
  kWall,        // Walls, facades, rock faces, partitions up to the ceiling; doors, panes, curtains
                // and pictures in and on them; the edges of floors.
  kPole,        // Trunks, lamp posts, columns, signposts with their signs: upright and thin.
  kVegetation,  // Crowns with their boughs, bushes, hedges, grass, the green of pot plants.
  kVehicle,     // Cars, vans, trucks, whether they stand or drive.
  kObject,      // Furniture, goods and their racks, machines, vessels, containers, boulders, fallen
                // trunks, statues, partitions below the ceiling.
  kStructure,   // Pipes, beams, ribs, cables, fences; guard rails with their posts, parapets.
  kMover,       // People, seen while they walk about.
};
constexpr int kPointClasses = 10;

// Stable lower-case name ("ground"); used in JSON, storage and messages.
const char* ToString(PointClass point_class);
// InvalidArgument, with the known names in the message, for any other name.
absl::StatusOr<PointClass> ParsePointClass(std::string_view name);

}  // namespace isthmus
