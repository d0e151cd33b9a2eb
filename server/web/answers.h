// The answers of a server that fails or refuses, as browsers understand them.
#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>

#include <string>

#include "server/http/exchange.h"

namespace isthmus::web {

// The code of HTTP that says most nearly the same.
int HttpCode(absl::StatusCode code);

// {"code":"NOT_FOUND","message":"..."}
std::string ErrorJson(const absl::Status& status);

// The error as JSON, with its code, and when to come again where the status says so.
http::Response ErrorAnswer(const absl::Status& status);
// With another code.
http::Response ErrorAnswer(int code, const absl::Status& status);

// The answer where all streams are taken: 503, and when to come again.
http::Response NoSlotLeft();

http::Response JsonAnswer(std::string json);
// An answer for programs, from the map as it is now.
http::Response FreshAnswer(absl::string_view type, std::string body);
http::Response TextAnswer(std::string text);

// ErrorAnswer of a method of HTTP that the address does not know; `allowed` as in "GET, HEAD".
http::Response WrongMethod(const std::string& allowed);

}  // namespace isthmus::web
