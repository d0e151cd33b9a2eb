// Any method of any service, called by its name with headers of the test's choosing.
#pragma once

#include <google/protobuf/message.h>
#include <google/protobuf/text_format.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/rpc/stubs.h"

namespace isthmus::rpc {

using Headers = std::vector<std::pair<std::string, std::string>>;

// The message of that type in protobuf's text form, as it travels.
inline std::string ToBytes(const google::protobuf::Descriptor* type, const std::string& text) {
  const std::unique_ptr<google::protobuf::Message> message(
      google::protobuf::MessageFactory::generated_factory()->GetPrototype(type)->New());
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(text, message.get())) << text;
  return message->SerializeAsString();
}

// "/package.Service/Method" with one request; all responses, as they travelled, in a row.
inline grpc::Status GenericCall(const std::shared_ptr<grpc::Channel>& channel,
                                const std::string& method, const Headers& headers,
                                const std::string& request, std::string* responses) {
  grpc::GenericStub stub(channel);
  const auto context = NewContext();
  for (const auto& [key, value] : headers) context->AddMetadata(key, value);
  grpc::CompletionQueue queue;
  const auto wait = [&queue] {
    void* tag = nullptr;
    bool ok = false;
    EXPECT_TRUE(queue.Next(&tag, &ok));
    return ok;
  };
  auto call = stub.PrepareCall(context.get(), method, &queue);
  call->StartCall(nullptr);
  wait();
  const grpc::Slice slice(request);
  call->WriteLast(grpc::ByteBuffer(&slice, 1), grpc::WriteOptions(), nullptr);
  wait();
  responses->clear();
  for (;;) {
    grpc::ByteBuffer buffer;
    call->Read(&buffer, nullptr);
    if (!wait()) break;
    std::vector<grpc::Slice> slices;
    EXPECT_TRUE(buffer.Dump(&slices).ok());
    for (const grpc::Slice& part : slices) {
      responses->append(reinterpret_cast<const char*>(part.begin()), part.size());
    }
  }
  grpc::Status status;
  call->Finish(&status, nullptr);
  wait();
  return status;
}

}  // namespace isthmus::rpc
