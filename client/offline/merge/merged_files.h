// The files that `merge` writes: the merged map, its drives' trajectories, a picture.
#pragma once

#include <absl/status/status.h>

#include <string>
#include <vector>

#include "client/library/client.h"
#include "client/offline/merge/merge_input.h"

namespace isthmus::cli {

struct MergedFiles {
  std::string map;           // .pcd or .ply.
  std::string trajectories;  // A folder; empty: none.
  std::string picture;       // .png, with a world file beside it; empty: none.
};

// Makes the folder. Errors of io::CheckOutput, where one of them cannot be written.
absl::Status PrepareFiles(const MergedFiles& files);

// Writes map 0, which must have points and stand still. Each drive in it gets ROBOT.tum,
// T_map_sensor in the frame of the merged map, and its input says so; finished maps and drives that
// lie in other maps get none. The picture has the drives' ways.
absl::Status WriteFiles(client::Client& client, const MergedFiles& files,
                        std::vector<MergeInput>& inputs);

}  // namespace isthmus::cli
