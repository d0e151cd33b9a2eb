// ROS 2 bags in SQLite databases.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>

#include "client/readers/messages/message_file.h"

namespace isthmus::readers {

// Source of the format: the tables `topics` (id, name, type, serialization_format) and `messages`
// (id, topic_id, timestamp in nanoseconds, data) of rosbag2_storage_sqlite3.
//
// The database is opened read-only and nothing is written beside it. What a recorder that was
// killed left in a write-ahead log beside it is read as well. Behind damaged pages it goes on with
// the next one that can be found. InvalidArgument for a database without these tables, DataLoss for one that is damaged
// from the beginning.
absl::StatusOr<std::shared_ptr<const MessageFile>> OpenDb3(const std::string& path);

}  // namespace isthmus::readers
