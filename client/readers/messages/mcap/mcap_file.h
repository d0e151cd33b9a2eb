// MCAP files.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>

#include "client/readers/messages/byte_source.h"
#include "client/readers/messages/message_file.h"

namespace isthmus::readers {

// With a summary that indexes the chunks, those without wanted messages are not read. Without one,
// or where its CRC is wrong, the heads of all records are read when it is opened, and those chunks
// unpacked that hold channels not seen before; behind what is damaged it goes on with the next
// chunk that can be found. The CRCs of chunks and of the summary are checked, that of the whole
// data section is not. Of a file with chunk indexes messages outside of chunks are left out.
absl::StatusOr<std::shared_ptr<const MessageFile>> OpenMcap(
    std::shared_ptr<const ByteSource> source, const std::string& name);

}  // namespace isthmus::readers
