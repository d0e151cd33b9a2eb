// Bags of ROS 1 in a folder: the parts of one drive.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>
#include <vector>

#include "client/readers/messages/message_file.h"

namespace isthmus::readers {

// The .bag files (and .bag.active, which a recorder left) of a folder; hidden ones are none.
std::vector<std::string> ListBags(const std::string& folder);

// Opens them as one drive: a single bag, or those that `rosbag record --split` writes, whose names
// end in 0, 1, 2 and so on. `bags` is not empty. InvalidArgument, naming them, for bags that count
// otherwise: they may be of several drives.
absl::StatusOr<std::shared_ptr<const MessageFile>> OpenSplitBag(
    const std::string& folder, const std::vector<std::string>& bags);

}  // namespace isthmus::readers
