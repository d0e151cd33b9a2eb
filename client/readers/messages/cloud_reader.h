// The scans of a topic whose messages are clouds.
#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>

#include "client/readers/messages/message_file.h"
#include "client/readers/messages/scan_topics.h"
#include "client/readers/recording.h"

namespace isthmus::readers {

// One scan for each message. Those before ReadOptions::from are not decoded.
std::unique_ptr<ScanReader> ReadClouds(const MessageTopic& topic, ScanMessage kind,
                                       std::unique_ptr<MessageReader> messages,
                                       const ReadOptions& options);

}  // namespace isthmus::readers
