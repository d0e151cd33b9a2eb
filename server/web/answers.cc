#include "server/web/answers.h"

#include <absl/strings/str_cat.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "api/convert/retry_after.h"
#include "server/web/caller.h"
#include "server/web/limits.h"

namespace isthmus::web {
int HttpCode(absl::StatusCode code) {
  switch (code) {
    case absl::StatusCode::kOk:
      return 200;
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kOutOfRange:
      return 400;
    case absl::StatusCode::kUnauthenticated:
      return 401;
    case absl::StatusCode::kPermissionDenied:
      return 403;
    case absl::StatusCode::kNotFound:
      return 404;
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kAborted:
      return 409;
    case absl::StatusCode::kResourceExhausted:
      return 429;
    case absl::StatusCode::kCancelled:
      return 499;  // Nobody reads it.
    case absl::StatusCode::kUnimplemented:
      return 501;
    case absl::StatusCode::kUnavailable:
      return 503;
    case absl::StatusCode::kDeadlineExceeded:
      return 504;
    default:
      return 500;
  }
}

std::string ErrorJson(const absl::Status& status) {
  const nlohmann::ordered_json error = {{"code", absl::StatusCodeToString(status.code())},
                                        {"message", std::string(status.message())}};
  return error.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

http::Response ErrorAnswer(const absl::Status& status) {
  return ErrorAnswer(HttpCode(status.code()), status);
}

http::Response ErrorAnswer(int code, const absl::Status& status) {
  http::Response response = JsonAnswer(ErrorJson(status) + "\n");
  response.code = code;
  if (absl::IsUnauthenticated(status)) response.Set("WWW-Authenticate", "Bearer");
  const auto after = convert::RetryAfter(status);
  if (after || absl::IsUnavailable(status)) {
    const auto seconds =
        after ? std::chrono::ceil<std::chrono::seconds>(*after).count() : kRetryAfterS;
    response.Set("Retry-After", absl::StrCat(seconds));
  }
  return response;
}

http::Response NoSlotLeft() {
  return ErrorAnswer(absl::UnavailableError(
      "as many streams as this server gives to browsers are open: close a page of it, or come "
      "again"));
}

http::Response JsonAnswer(std::string json) {
  http::Response response;
  response.Set("Content-Type", kJsonType);
  response.Set("Cache-Control", "no-store");
  response.body = std::move(json);
  return response;
}

http::Response FreshAnswer(absl::string_view type, std::string body) {
  http::Response response;
  response.Set("Cache-Control", "no-store");
  response.Set("Content-Type", type);
  response.body = std::move(body);
  return response;
}

http::Response TextAnswer(std::string text) {
  return FreshAnswer("text/plain; charset=utf-8", std::move(text));
}

http::Response WrongMethod(const std::string& allowed) {
  http::Response response = ErrorAnswer(
      405, absl::UnimplementedError(absl::StrCat("this address knows ", allowed, " alone")));
  response.Set("Allow", allowed);
  return response;
}

}  // namespace isthmus::web
