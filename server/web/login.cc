#include "server/web/login.h"

#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "server/web/answers.h"
#include "server/web/caller.h"
#include "server/web/limits.h"
#include "server/web/rpc_call.h"

namespace isthmus::web {
namespace {

// Any reader may ask it.
constexpr char kCheapCall[] = "MapService/GetMapInfo";

absl::Status CheckPost(const http::Request& request) {
  absl::Status status = CheckSender(request);
  if (!status.ok() || MediaTypeOf(request) == kJsonType) return status;
  return absl::InvalidArgumentError("a token comes as JSON: Content-Type: application/json");
}

http::Response AnswerWithCookie(const http::Request& request, const std::string& value,
                                const char* more) {
  http::Response response = JsonAnswer("{}\n");
  response.Set("Set-Cookie",
               absl::StrCat(kTokenCookie, "=", value, "; Path=/; HttpOnly; SameSite=Strict", more,
                            request.is_tls ? "; Secure" : ""));
  return response;
}

}  // namespace

http::Response LogIn(const http::Request& request, const std::shared_ptr<grpc::Channel>& channel) {
  if (request.method != "POST") return WrongMethod("POST");
  if (absl::Status status = CheckPost(request); !status.ok()) return ErrorAnswer(status);
  const auto body = nlohmann::json::parse(request.body, nullptr, false);
  const auto given = body.is_object() ? body.find("token") : body.end();
  const bool is_text = body.is_object() && given != body.end() && given->is_string();
  std::string token = is_text ? given->get<std::string>() : std::string();
  absl::StripAsciiWhitespace(&token);  // It may be a whole line of a file.
  if (!IsTokenText(token)) {
    return ErrorAnswer(absl::InvalidArgumentError("send {\"token\": \"...\"} with a token in it"));
  }
  http::Request as = request;
  std::erase_if(as.headers, [](const auto& field) {
    return absl::EqualsIgnoreCase(field.first, "authorization");
  });
  as.headers.emplace_back("authorization", absl::StrCat("Bearer ", token));
  RpcCall::Request call = RpcCall::For(as, kCheapCall, "");
  call.deadline = kCallTime;
  RpcCall check(channel, std::move(call));
  std::string answer;
  while (check.Take({}, &answer) != RpcCall::Next::kEnd) {
  }
  if (!check.status().ok()) return ErrorAnswer(check.status());
  return AnswerWithCookie(request, token, "");
}

http::Response LogOut(const http::Request& request) {
  if (request.method != "POST") return WrongMethod("POST");
  if (absl::Status status = CheckPost(request); !status.ok()) return ErrorAnswer(status);
  http::Response response = AnswerWithCookie(request, "", "; Max-Age=0");
  response.Set("Clear-Site-Data", "\"cache\"");  // Tiles that the browser kept.
  return response;
}

}  // namespace isthmus::web
