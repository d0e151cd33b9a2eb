// The messages of a ROS 2 bag's database, in the order of their recording.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "client/readers/messages/message_file.h"

namespace isthmus::readers {

// `topic_of`: those that are wanted, by their ids in the database. `last_id`: of the last message,
// beyond which it does not look for undamaged ones; 0 where that is not known. The first call lists
// the messages, 24 bytes each, and tells of damaged pages first. Errors of BagDatabase.
absl::StatusOr<std::unique_ptr<MessageReader>> ReadDb3(const std::string& path,
                                                       std::map<int64_t, size_t> topic_of,
                                                       int64_t last_id);

}  // namespace isthmus::readers
