// Recorded drives among what is to be merged: robots whose odometry is still to be computed.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <set>
#include <string>
#include <vector>

#include "client/console/push_scans.h"
#include "client/console/recording_options.h"
#include "client/library/client.h"
#include "client/offline/merge/merge_input.h"

namespace isthmus::cli {

struct Drives {
  std::vector<RobotScans> robots;
  std::vector<MergeInput> inputs;  // One for each, without submaps.
};

// False for a file that is one cloud: a finished map.
bool IsDrive(const std::string& path);

// Opens the recordings. A robot is named by its topic's option, else after its file, unlike those
// in `names`, which its own joins. Topics that the options name are looked for in every recording.
absl::StatusOr<Drives> OpenDrives(const std::vector<std::string>& paths,
                                  const RecordingOptions& options, std::set<std::string>& names);

// Pushes all of them at the same time, and notes in their inputs what was seen.
absl::Status PushDrives(client::Client& client, Drives& drives, PushControl& control);

}  // namespace isthmus::cli
