// Messages as streams carry them: bytes, so that reading them costs gRPC's threads nothing, and one
// that is damaged can be told from the end of the stream.
#pragma once

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>
#include <google/protobuf/message.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/proto_buffer_reader.h>
#include <grpcpp/support/proto_buffer_writer.h>

#include "api/convert/bounds.h"

namespace isthmus::rpc {

// InvalidArgument for bytes that are no such message, or hold more than convert::CheckBounds takes.
// Lets go of them.
inline absl::Status ReadMessage(grpc::ByteBuffer* bytes, google::protobuf::Message* message) {
  bool is_read = false;
  {
    grpc::ProtoBufferReader reader(bytes);
    is_read = reader.status().ok() && message->ParseFromZeroCopyStream(&reader);
  }
  bytes->Clear();
  if (is_read) return convert::CheckBounds(*message);
  return absl::InvalidArgumentError(absl::StrCat("what came is no ",
                                                 message->GetDescriptor()->name(),
                                                 ": the bytes are damaged, or of another program"));
}

inline grpc::ByteBuffer ToBytes(const google::protobuf::Message& message) {
  grpc::ByteBuffer bytes;
  const int size = static_cast<int>(message.ByteSizeLong());
  grpc::ProtoBufferWriter writer(&bytes, size == 0 ? 1 : size, size);
  message.SerializeToZeroCopyStream(&writer);
  return bytes;
}

}  // namespace isthmus::rpc
