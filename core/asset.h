// Files that are part of the program; isthmus_embed (cmake/embed.cmake) makes them.
#pragma once

#include <absl/strings/string_view.h>

#include <vector>

namespace isthmus {

struct Asset {
  absl::string_view path;  // "/index.html".
  absl::string_view type;  // "text/html; charset=utf-8".
  absl::string_view content;
  absl::string_view gzip;  // The same, packed; empty where that is no smaller.
};

using Assets = std::vector<Asset>;

}  // namespace isthmus
