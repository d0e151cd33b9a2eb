// The messages of one method of the API, as HTTP carries them: JSON, or protobuf's own bytes.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <google/protobuf/descriptor.h>

#include <string>

#include "server/http/exchange.h"

namespace isthmus::web {

// Messages are as the proto3 mapping has them: https://protobuf.dev/programming-guides/json
class Transcoder {
 public:
  // As the request's Content-Type says. The method must outlive it.
  Transcoder(const google::protobuf::MethodDescriptor* method, const http::Request& request);

  // The bytes of the request's message. InvalidArgument, saying where it is not one.
  absl::StatusOr<std::string> Decode(const std::string& body) const;

  // The one answer of a call, from its bytes; Internal where they are none.
  absl::StatusOr<http::Response> Answer(const std::string& message) const;

  // One of many answers: a line of JSON; or a byte 0, its size in four bytes, big endian, and it.
  absl::StatusOr<std::string> Piece(const std::string& message) const;
  // The sign of a stream that is silent but alive: an empty line; or a byte 1 and a size of 0.
  std::string Silence() const;
  // Behind the last piece where the call failed: a line {"error": {...}}; or a byte 0x80, a size,
  // and the text in those braces.
  std::string Error(const absl::Status& status) const;
  const char* stream_type() const;

 private:
  absl::StatusOr<std::string> ToJson(const std::string& message) const;

  const google::protobuf::MethodDescriptor* const method_;
  const bool is_json_;
};

}  // namespace isthmus::web
