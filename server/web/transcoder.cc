#include "server/web/transcoder.h"

#include <absl/strings/str_cat.h>
#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>

#include <cstdint>
#include <memory>

#include "server/web/answers.h"
#include "server/web/caller.h"

namespace isthmus::web {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::Message;

constexpr char kMessage = 0, kAlive = 1, kError = '\x80';  // Format

std::unique_ptr<Message> NewMessage(const Descriptor* type) {
  return std::unique_ptr<Message>(
      google::protobuf::MessageFactory::generated_factory()->GetPrototype(type)->New());
}

std::string Framed(char kind, const std::string& bytes) {
  std::string frame(1, kind);
  for (int shift = 24; shift >= 0; shift -= 8) {
    frame += static_cast<char>(static_cast<uint32_t>(bytes.size()) >> shift);
  }
  return frame + bytes;
}

}  // namespace

Transcoder::Transcoder(const google::protobuf::MethodDescriptor* method,
                       const http::Request& request)
    : method_(method), is_json_(MediaTypeOf(request) != kProtobufType) {}

absl::StatusOr<std::string> Transcoder::Decode(const std::string& body) const {
  if (body.empty()) return std::string();
  const std::unique_ptr<Message> message = NewMessage(method_->input_type());
  if (!is_json_) {
    if (message->ParseFromString(body)) return body;
    return absl::InvalidArgumentError(
        absl::StrCat("these bytes are no ", method_->input_type()->name()));
  }
  const auto status = google::protobuf::util::JsonStringToMessage(body, message.get());
  if (!status.ok()) {
    return absl::InvalidArgumentError(absl::StrCat("this is no ", method_->input_type()->name(),
                                                   " in JSON: ", status.message().ToString()));
  }
  return message->SerializeAsString();
}

absl::StatusOr<std::string> Transcoder::ToJson(const std::string& bytes) const {
  const std::unique_ptr<Message> message = NewMessage(method_->output_type());
  std::string json;
  if (!message->ParseFromString(bytes) ||
      !google::protobuf::util::MessageToJsonString(*message, &json).ok()) {
    return absl::InternalError(
        absl::StrCat("the answer cannot be told in JSON: ask as application/x-protobuf"));
  }
  return json;
}

absl::StatusOr<http::Response> Transcoder::Answer(const std::string& message) const {
  if (is_json_) {
    auto json = ToJson(message);
    if (!json.ok()) return json.status();
    return JsonAnswer(*json + "\n");
  }
  http::Response response;
  response.Set("Content-Type", kProtobufType);
  response.Set("Cache-Control", "no-store");
  response.body = message;
  return response;
}

absl::StatusOr<std::string> Transcoder::Piece(const std::string& message) const {
  if (!is_json_) return Framed(kMessage, message);
  auto json = ToJson(message);
  if (!json.ok()) return json.status();
  return *json + "\n";
}

std::string Transcoder::Silence() const { return is_json_ ? "\n" : Framed(kAlive, ""); }

std::string Transcoder::Error(const absl::Status& status) const {
  const std::string error = ErrorJson(status);
  return is_json_ ? absl::StrCat("{\"error\":", error, "}\n") : Framed(kError, error);
}

const char* Transcoder::stream_type() const {
  return is_json_ ? "application/x-ndjson" : kProtobufType;
}

}  // namespace isthmus::web
