#include "server/web/caller.h"

#include <absl/strings/ascii.h>
#include <absl/strings/escaping.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/strings/strip.h>
#include <arpa/inet.h>
#include <unistd.h>

#include <algorithm>
#include <optional>

#include "server/rpc/call_origin.h"
#include "server/web/limits.h"

namespace isthmus::web {
namespace {

// "host" of "host", "host:80" and "[::1]:80".
std::string HostOf(absl::string_view authority) {
  if (absl::StartsWith(authority, "[")) {
    const size_t end = authority.find(']');
    return std::string(end == absl::string_view::npos ? authority : authority.substr(1, end - 1));
  }
  return std::string(authority.substr(0, authority.rfind(':')));
}

bool IsAddress(const std::string& host) {
  in6_addr address = {};
  return inet_pton(AF_INET, host.c_str(), &address) == 1 ||
         inet_pton(AF_INET6, host.c_str(), &address) == 1;
}

std::string OwnName() {
  char name[256] = "";
  return gethostname(name, sizeof(name) - 1) == 0 ? name : "";
}

}  // namespace

http::Fields CallHeaders(const http::Request& request) {
  http::Fields headers = {{rpc::kPeerHeader, request.peer}};
  // Text that gRPC would not take is escaped, and then neither a token nor a site that there is.
  const auto add = [&headers](const char* name, const std::optional<std::string>& value) {
    if (value) headers.emplace_back(name, absl::CHexEscape(*value));
  };
  std::optional<std::string> token = request.Header("authorization");
  if (!token) {
    token = request.Cookie(kTokenCookie);
    if (token) token = absl::StrCat("Bearer ", *token);
  }
  add("authorization", token);
  std::optional<std::string> site = request.Header("isthmus-site");
  if (!site) site = request.Query("site");
  add("isthmus-site", site);
  add("x-request-id", request.Header("x-request-id"));
  return headers;
}

std::string MediaTypeOf(const http::Request& request) {
  const std::string whole = request.Header("content-type").value_or("");
  const absl::string_view type = absl::string_view(whole).substr(0, whole.find(';'));
  return absl::AsciiStrToLower(absl::StripAsciiWhitespace(type));
}

bool IsTokenText(absl::string_view text) {
  return !text.empty() && text.size() <= kMaxToken &&
         std::all_of(text.begin(), text.end(), [](char c) {
           return absl::ascii_isalnum(static_cast<unsigned char>(c)) ||
                  absl::StrContains("-._~+/=", absl::string_view(&c, 1));
         });
}

absl::Status CheckSender(const http::Request& request) {
  const std::optional<std::string> origin = request.Header("origin"), host = request.Header("host");
  if (origin) {
    const size_t slashes = origin->find("://");
    const bool is_ours = host && slashes != std::string::npos &&
                         absl::EqualsIgnoreCase(origin->substr(slashes + 3), *host);
    if (!is_ours) {
      return absl::PermissionDeniedError(
          "a page of another server sent this: open the one of this server, and in front of it let "
          "a proxy pass the header Host on");
    }
  }
  const std::string type = MediaTypeOf(request);
  if (type == kJsonType || type == kProtobufType) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "give the type of the request: Content-Type: application/json, or application/x-protobuf");
}

bool IsOurHost(const http::Request& request, absl::string_view hosts) {
  if (request.is_tls) return true;
  const std::optional<std::string> asked = request.Header("host");
  if (!asked) return true;  // HTTP/1.0: no browser.
  const std::string host = HostOf(*asked);
  const auto is = [&host](absl::string_view name) {
    return !name.empty() && absl::EqualsIgnoreCase(host, name);
  };
  static const std::string own = OwnName();
  if (IsAddress(host) || is("localhost") || is(own) || is(absl::StrCat(own, ".local"))) {
    return true;
  }
  const std::vector<absl::string_view> named = absl::StrSplit(hosts, ' ', absl::SkipEmpty());
  return std::any_of(named.begin(), named.end(), is);
}

}  // namespace isthmus::web
