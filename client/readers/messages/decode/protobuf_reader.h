// The fields of a protobuf message, one after the other.
#pragma once

#include <absl/strings/string_view.h>

#include <cstdint>

namespace isthmus::readers {

// A field as it is on the wire (protobuf.dev, "Encoding").
struct ProtobufField {
  uint32_t number = 0;
  uint64_t value = 0;       // Varints and fixed numbers, as they are.
  absl::string_view bytes;  // Strings, bytes and messages.
};

// Goes through `message`. ok() is false where it is damaged or uses groups.
class ProtobufReader {
 public:
  explicit ProtobufReader(absl::string_view message) : rest_(message) {}

  // False behind the last field, and where it is damaged.
  bool Next(ProtobufField& field);
  bool ok() const { return ok_; }

 private:
  uint64_t ReadVarint();
  absl::string_view Take(uint64_t size);
  uint64_t ReadFixed(uint64_t size);

  absl::string_view rest_;
  bool ok_ = true;
};

}  // namespace isthmus::readers
