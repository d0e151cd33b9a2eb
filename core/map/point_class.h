// The kinds of things that points of a map lie on.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string_view>
#include <vector>

namespace isthmus {

// The numbers are stored and trained on: new classes come last.
enum class PointClass : uint32_t {
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

// Some of the classes. Value type.
class PointClasses {
 public:
  PointClasses() = default;  // All.
  // All where there is none.
  explicit PointClasses(const std::vector<PointClass>& some) {
    for (const PointClass of : some) bits_ |= Bit(of);
  }

  bool has_all() const { return bits_ == 0; }
  bool Has(PointClass of) const { return has_all() || (bits_ & Bit(of)) != 0; }

 private:
  static uint32_t Bit(PointClass of) { return uint32_t{1} << static_cast<uint32_t>(of); }

  uint32_t bits_ = 0;
};

// Stable lower-case name ("ground"); used in JSON, storage and messages.
const char* ToString(PointClass point_class);
// InvalidArgument, with the known names in the message, for any other name.
absl::StatusOr<PointClass> ParsePointClass(std::string_view name);

}  // namespace isthmus
