// Folders of scans, and single files of one, as recordings.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>

#include "client/readers/recording.h"

namespace isthmus::readers {

// The scans that FindScans finds, stamped as StampsOf says. Its readers know how many they are, and
// the sensor: "sensor" in simulation.json in the folder or beside it; hdl64 for a .bin
// without rings; by the rings of the first scan otherwise. Errors as those of FindScans; OpenScans
// gives those of StampsOf.
absl::StatusOr<std::unique_ptr<Recording>> OpenFolderRecording(const std::string& path);

}  // namespace isthmus::readers
