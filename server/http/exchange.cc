#include "server/http/exchange.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/strings/strip.h>

namespace isthmus::http {

std::optional<std::string> Request::Header(absl::string_view name) const {
  std::optional<std::string> all;
  for (const auto& [key, value] : headers) {
    if (!absl::EqualsIgnoreCase(key, name)) continue;
    all = all ? absl::StrCat(*all, ", ", value) : value;
  }
  return all;
}

std::optional<std::string> Request::Query(absl::string_view name) const {
  for (const auto& [key, value] : query) {
    if (key == name) return value;
  }
  return std::nullopt;
}

std::optional<std::string> Request::Cookie(absl::string_view name) const {
  const std::optional<std::string> all = Header("cookie");
  if (!all) return std::nullopt;
  for (absl::string_view cookie : absl::StrSplit(*all, absl::ByAnyChar(";,"))) {
    cookie = absl::StripAsciiWhitespace(cookie);
    if (absl::ConsumePrefix(&cookie, name) && absl::ConsumePrefix(&cookie, "=")) {
      return std::string(cookie);
    }
  }
  return std::nullopt;
}

Response Text(int code, std::string text) {
  Response response;
  response.code = code;
  response.Set("Content-Type", "text/plain; charset=utf-8");
  response.body = std::move(text);
  return response;
}

}  // namespace isthmus::http
