// The files of a page that are part of the program; isthmus_embed (cmake/embed.cmake) makes them.
#pragma once

#include <absl/strings/string_view.h>

#include <vector>

#include "server/http/exchange.h"

namespace isthmus::web {

struct Asset {
  absl::string_view path;  // "/index.html".
  absl::string_view type;  // "text/html; charset=utf-8".
  absl::string_view content;
  absl::string_view gzip;  // The same, packed; empty where that is no smaller.
};

using Assets = std::vector<Asset>;

// The viewer's, of client/viewer; none where it was not built.
const Assets& ViewerAssets();

// The asset of the request's path, "/" being /index.html. Assets below /assets/ have a hash of
// their content in their names and may be kept for ever. If there is no asset at all, "/" says so.
http::Response AnswerAsset(const http::Request& request, const Assets& assets);

}  // namespace isthmus::web
