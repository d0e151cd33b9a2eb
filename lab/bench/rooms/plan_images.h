// Floor plans as images, with and without furniture, and the same with the rooms parted by lines:
// the evaluation set of Fraunhofer IPA's ipa_room_segmentation.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "core/floors/grid_map.h"
#include "lab/bench/rooms/judge.h"

namespace isthmus::bench {

struct PlanImages {
  std::string name;
  floors::GridMap bare, furnished;
  TrueRooms truth;
};

// The names of plans in a folder, sorted: NAME of each NAME_gt_segmentation.png.
std::vector<std::string> PlansIn(const std::string& folder);

// Reads NAME.png, NAME_furnitures.png and NAME_gt_segmentation.png. White is free; the lower left
// corner is the origin. True rooms are white areas that the lines of the last part, of 1 m2 or
// more; true doors are where a line between two of them is 2.5 m long or shorter. InvalidArgument
// for what is no PNG or not of one size.
absl::StatusOr<PlanImages> ReadPlan(const std::string& folder, const std::string& name);

}  // namespace isthmus::bench
