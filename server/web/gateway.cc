#include "server/web/gateway.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_replace.h>
#include <google/protobuf/descriptor.h>

#include <string>
#include <utility>

#include "server/web/answers.h"
#include "server/web/caller.h"
#include "server/web/limits.h"
#include "server/web/rpc_call.h"
#include "server/web/transcoder.h"

namespace isthmus::web {
namespace {

using google::protobuf::MethodDescriptor;

constexpr char kOurs[] = "isthmus.v1.";

// Null where there is none.
const MethodDescriptor* Find(absl::string_view method) {
  if (!absl::StartsWith(method, kOurs)) return nullptr;
  return google::protobuf::DescriptorPool::generated_pool()->FindMethodByName(
      absl::StrReplaceAll(method, {{"/", "."}}));
}

// The answers of a call, of which the first may be there already.
class CallSource final : public http::Source {
 public:
  CallSource(const Transcoder& transcoder, std::unique_ptr<RpcCall> call, std::string first,
             std::unique_ptr<StreamSlots::Slot> slot)
      : slot_(std::move(slot)),
        transcoder_(transcoder),
        call_(std::move(call)),
        first_(std::move(first)) {}

  Next Take(std::string* piece) override {
    if (is_over_) return Next::kEnd;
    if (!first_.empty()) {
      *piece = std::exchange(first_, "");
      return Next::kPiece;
    }
    std::string message;
    switch (call_->Take(kSilence, &message)) {
      case RpcCall::Next::kNothingYet:
        *piece = transcoder_.Silence();
        return Next::kPiece;
      case RpcCall::Next::kEnd:
        is_over_ = true;
        if (call_->status().ok()) return Next::kEnd;
        *piece = transcoder_.Error(call_->status());
        return Next::kPiece;
      case RpcCall::Next::kMessage:
        break;
    }
    auto told = transcoder_.Piece(message);
    is_over_ = !told.ok();
    *piece = told.ok() ? *std::move(told) : transcoder_.Error(told.status());
    return Next::kPiece;
  }

 private:
  const std::unique_ptr<StreamSlots::Slot> slot_;  // Given up when the call is over.
  const Transcoder transcoder_;
  const std::unique_ptr<RpcCall> call_;
  std::string first_;
  bool is_over_ = false;
};

http::Response AnswerOnce(const Transcoder& transcoder, RpcCall* call) {
  std::string message, none;
  const bool has_answer = call->Take({}, &message) == RpcCall::Next::kMessage;
  if (has_answer) call->Take({}, &none);
  if (!call->status().ok()) return ErrorAnswer(call->status());
  if (!has_answer) return ErrorAnswer(absl::InternalError("there was no answer"));
  auto answer = transcoder.Answer(message);
  return answer.ok() ? *std::move(answer) : ErrorAnswer(answer.status());
}

http::Response AnswerByStream(const Transcoder& transcoder, std::unique_ptr<RpcCall> call,
                              std::unique_ptr<StreamSlots::Slot> slot) {
  std::string message, first;
  const RpcCall::Next next = call->Take(kHoldHeaders, &message);
  if (next == RpcCall::Next::kEnd && !call->status().ok()) return ErrorAnswer(call->status());
  if (next == RpcCall::Next::kMessage) {
    auto told = transcoder.Piece(message);
    if (!told.ok()) return ErrorAnswer(told.status());
    first = *std::move(told);
  }
  http::Response response;
  response.Set("Content-Type", transcoder.stream_type());
  response.Set("Cache-Control", "no-store");
  response.source =
      std::make_unique<CallSource>(transcoder, std::move(call), std::move(first), std::move(slot));
  return response;
}

}  // namespace

http::Response Gateway::Answer(const http::Request& request, absl::string_view method) const {
  if (request.method != "POST") return WrongMethod("POST");
  if (absl::Status status = CheckSender(request); !status.ok()) return ErrorAnswer(status);
  const MethodDescriptor* const known = Find(method);
  if (known == nullptr) {
    return ErrorAnswer(
        404, absl::UnimplementedError("there is no such method: docs/api-reference.md lists "
                                      "all methods, as /rpc/isthmus.v1.SERVICE/METHOD"));
  }
  if (known->client_streaming()) {
    return ErrorAnswer(absl::UnimplementedError(
        "methods with a stream of requests need gRPC: HTTP carries one request"));
  }
  const Transcoder transcoder(known, request);
  auto message = transcoder.Decode(request.body);
  if (!message.ok()) return ErrorAnswer(message.status());
  std::unique_ptr<StreamSlots::Slot> slot;
  if (known->server_streaming()) slot = slots_->Take(request.peer);
  if (known->server_streaming() && slot == nullptr) return NoSlotLeft();
  RpcCall::Request call = RpcCall::For(
      request, absl::StrCat(known->service()->name(), "/", known->name()), *std::move(message));
  if (known->server_streaming()) {
    return AnswerByStream(transcoder, std::make_unique<RpcCall>(channel_, std::move(call)),
                          std::move(slot));
  }
  call.deadline = kCallTime;
  RpcCall once(channel_, std::move(call));
  return AnswerOnce(transcoder, &once);
}

}  // namespace isthmus::web
