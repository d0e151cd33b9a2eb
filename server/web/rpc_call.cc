#include "server/web/rpc_call.h"

#include <absl/strings/str_cat.h>
#include <grpcpp/support/byte_buffer.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "api/convert/retry_after.h"
#include "server/web/caller.h"
#include "server/web/limits.h"

namespace isthmus::web {
namespace {

grpc::ByteBuffer BufferOf(const std::string& message) {
  const grpc::Slice slice(message);
  return grpc::ByteBuffer(&slice, 1);
}

void CopyOut(const grpc::ByteBuffer& buffer, std::string* message) {
  message->clear();
  std::vector<grpc::Slice> slices;
  if (!buffer.Dump(&slices).ok()) return;
  for (const grpc::Slice& slice : slices) {
    message->append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
}

}  // namespace

RpcCall::Request RpcCall::For(const http::Request& request, absl::string_view method,
                              std::string message) {
  Request asked;
  asked.method = absl::StrCat("/isthmus.v1.", method);
  asked.headers = CallHeaders(request);
  asked.message = std::move(message);
  asked.gone = request.gone;
  return asked;
}

RpcCall::RpcCall(const std::shared_ptr<grpc::Channel>& channel, Request request)
    : request_(std::move(request)), stub_(channel) {
  for (const auto& [name, value] : request_.headers) context_.AddMetadata(name, value);
  if (request_.deadline.count() > 0) {
    context_.set_deadline(std::chrono::system_clock::now() + request_.deadline);
  }
  call_ = stub_.PrepareCall(&context_, request_.method, &queue_);
  call_->StartCall(nullptr);
  if (!WaitForTag()) {
    Finish();
    return;
  }
  call_->WriteLast(BufferOf(request_.message), grpc::WriteOptions(), nullptr);
  WaitForTag();  // One that was refused meanwhile says so at the end of its answers.
}

RpcCall::~RpcCall() {
  if (!is_over_) {
    context_.TryCancel();
    if (is_reading_) WaitForTag();
    Finish();
  }
  queue_.Shutdown();
  void* tag = nullptr;
  bool ok = false;
  while (queue_.Next(&tag, &ok)) {
  }
}

bool RpcCall::WaitForTag() {
  bool has_come = false;
  return WaitForTag(std::chrono::milliseconds(0), &has_come);
}

bool RpcCall::WaitForTag(std::chrono::milliseconds patience, bool* has_come) {
  using std::chrono::system_clock;
  const auto until = system_clock::now() + patience;
  *has_come = false;
  for (;;) {
    void* tag = nullptr;
    bool ok = false;
    auto look = system_clock::now() + kLookTime;
    if (patience.count() > 0) look = std::min(look, until);
    if (queue_.AsyncNext(&tag, &ok, look) == grpc::CompletionQueue::GOT_EVENT) {
      *has_come = true;
      return ok;
    }
    if (request_.gone()) {
      context_.TryCancel();
    } else if (patience.count() > 0 && system_clock::now() >= until) {
      return true;
    }
  }
}

void RpcCall::Finish() {
  grpc::Status status;
  call_->Finish(&status, nullptr);
  WaitForTag();
  is_over_ = true;
  status_ = convert::WithDetails(
      absl::Status(static_cast<absl::StatusCode>(status.error_code()), status.error_message()),
      status.error_details());
}

RpcCall::Next RpcCall::Take(std::chrono::milliseconds patience, std::string* message) {
  if (is_over_) return Next::kEnd;
  if (!is_reading_) call_->Read(&buffer_, nullptr);
  is_reading_ = true;
  bool has_come = false;
  const bool ok = WaitForTag(patience, &has_come);
  if (!has_come) return Next::kNothingYet;
  is_reading_ = false;
  if (!ok) {
    Finish();
    return Next::kEnd;
  }
  CopyOut(buffer_, message);
  return Next::kMessage;
}

}  // namespace isthmus::web
