// ROS 1 bags, of version 2.0.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>

#include "client/readers/messages/byte_source.h"
#include "client/readers/messages/message_file.h"

namespace isthmus::readers {

// With an index, chunks without wanted messages are not even read. Without one, as a recorder
// leaves it that was killed (.bag.active), or where it is damaged, the heads of all chunks are read
// when the bag is opened, and those chunks unpacked that hold topics not seen before; behind what
// is damaged it goes on with the next chunk that can be found. InvalidArgument for bags that are
// encrypted, saying what to do.
absl::StatusOr<std::shared_ptr<const MessageFile>> OpenBag(std::shared_ptr<const ByteSource> source,
                                                           const std::string& name);

}  // namespace isthmus::readers
