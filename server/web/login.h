// A token as a cookie, so that links of a page carry it.
#pragma once

#include <grpcpp/channel.h>

#include <memory>

#include "server/http/exchange.h"

namespace isthmus::web {

// POST /login with {"token": "..."} as JSON: has the browser keep the token where no script reads
// it and no other page's requests carry it, if it is one that may read the map; else the error of
// that call.
http::Response LogIn(const http::Request& request, const std::shared_ptr<grpc::Channel>& channel);

// POST /logout: has the browser forget it.
http::Response LogOut(const http::Request& request);

}  // namespace isthmus::web
