// The folders of ROS 2 bags: metadata.yaml and one or several databases or MCAP files.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>

#include "client/readers/messages/message_file.h"

namespace isthmus::readers {

// Source of metadata.yaml: rosbag2_storage, versions 1 to 9. The files that it lists are read in
// its order, or, where a recorder was killed before it wrote one, those in the folder in the order
// of the numbers in their names. Files that are missing or cannot be read are left out, and said
// in the notes. InvalidArgument for files compressed as a whole, saying what to do; NotFound where
// no file can be read.
absl::StatusOr<std::shared_ptr<const MessageFile>> OpenBagFolder(const std::string& path);

// True if there is a metadata.yaml of a bag, or a .db3 or .mcap (compressed or not).
bool IsBagFolder(const std::string& path);

}  // namespace isthmus::readers
