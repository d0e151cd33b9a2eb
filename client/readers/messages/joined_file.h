// Files of one recording, one behind the other.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "client/readers/messages/message_file.h"

namespace isthmus::readers {

// Topics are joined by name, type and encoding. A file is opened for reading when the one before
// has ended. At least one file. `messages`: how many there are of a topic's name, where the files
// do not tell.
std::shared_ptr<const MessageFile> JoinFiles(std::vector<std::shared_ptr<const MessageFile>> files,
                                             std::string kind, std::vector<std::string> notes,
                                             const std::map<std::string, uint64_t>& messages);

}  // namespace isthmus::readers
