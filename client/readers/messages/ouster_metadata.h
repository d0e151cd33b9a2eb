// The metadata of Ouster's sensors, where a recording has them.
#pragma once

#include <absl/status/statusor.h>

#include <string>

#include "client/readers/messages/message_file.h"

namespace isthmus::readers {

// The JSON for the packets on `topic`: the contents of the file `metadata`, or where that is empty
// of the topic ".../metadata" next to it by name, or of a .json beside `path` (with the same name,
// or the only one). NotFound, saying what to do, where there is none.
absl::StatusOr<std::string> FindOusterMetadata(const MessageFile& file, const std::string& path,
                                               const std::string& topic,
                                               const std::string& metadata);

// The contents of a file of text that an option names. NotFound, InvalidArgument for what is too
// large to be one.
absl::StatusOr<std::string> ReadTextFile(const std::string& path);

}  // namespace isthmus::readers
