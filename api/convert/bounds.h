// Bounds of everything in a request that has no length of its own.
#pragma once

#include <absl/status/status.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <cstddef>
#include <limits>

namespace isthmus::convert {

// The bound of bytes that only the size of a message bounds: points.
inline constexpr size_t kAsTheMessage = std::numeric_limits<size_t>::max();

struct FieldBound {
  size_t values = 0;  // Most values of a repeated field.
  size_t length = 0;  // Bytes of each, of strings and bytes.
};

// The bound of a string, bytes or repeated field of a request, by its name: fields of one name mean
// the same in all requests. What has no bound of its own is a name, or a list of a hundred at most.
FieldBound BoundOf(const google::protobuf::FieldDescriptor& field);

// InvalidArgument, naming the field, where any field of `message`, or of what it holds, has more
// than it may. Not of the clouds in it: FromServer asks for each by itself, as a scan whose cloud
// cannot be used is rejected and its stream goes on.
absl::Status CheckBounds(const google::protobuf::Message& message);

}  // namespace isthmus::convert
