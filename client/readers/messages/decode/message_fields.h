// The parts that ROS messages have in common.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <string>

#include "client/readers/messages/field_reader.h"

namespace isthmus::readers {

// std_msgs/Header.
struct MessageHeader {
  int64_t stamp_ns = 0;  // Nanoseconds since the Unix epoch; 0: not stamped.
  std::string frame;
};

// A reader of messages in that encoding, "ros1" or "cdr". InvalidArgument for another one.
absl::StatusOr<FieldReader> OpenFields(absl::string_view encoding, absl::string_view bytes);

int64_t ReadStamp(FieldReader& reader);
MessageHeader ReadHeader(FieldReader& reader);

// For a message that ends before its fields do.
absl::Status TooShort(absl::string_view type);

}  // namespace isthmus::readers
