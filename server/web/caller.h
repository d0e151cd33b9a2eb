// The caller over HTTP, as the services of the server want to know it.
#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>

#include <string>

#include "server/http/exchange.h"

namespace isthmus::web {

inline constexpr char kTokenCookie[] = "isthmus_token";

// Headers of a call for it: its token, from the header or else the cookie; its site, from the
// header or else ?site=; its peer; and its own id of the request.
http::Fields CallHeaders(const http::Request& request);

// True if the text can be a token: it can stand in a header and a cookie as it is.
bool IsTokenText(absl::string_view text);

inline constexpr char kJsonType[] = "application/json";
inline constexpr char kProtobufType[] = "application/x-protobuf";

// The type of its body, as above: in lower case, without parameters. Empty where it says none.
std::string MediaTypeOf(const http::Request& request);

// Checks that a page of this server, or none, sent a request that may change something: its origin,
// if any, is the host asked, and its content is of a type that no form sends. PermissionDenied or
// InvalidArgument else.
absl::Status CheckSender(const http::Request& request);

// True if the request asked for a name of this server, so that no name that somebody else points
// here makes pages of theirs ours (DNS rebinding): an address, localhost, this machine's own name,
// or one of `hosts`, separated by spaces. With TLS the certificate says so.
bool IsOurHost(const http::Request& request, absl::string_view hosts);

}  // namespace isthmus::web
