#include "server/web/asset.h"

#include <absl/strings/match.h>
#include <absl/strings/str_split.h>
#include <absl/strings/strip.h>

#include <algorithm>
#include <string>

#include "server/web/answers.h"

namespace isthmus::web {
namespace {

constexpr char kIndex[] = "/index.html", kHashed[] = "/assets/";
constexpr char kNotBuilt[] =
    "This server was built without its viewer, which needs npm: cmake -DISTHMUS_VIEWER=ON.\nThe "
    "other pages of docs/web.md work.\n";

bool TakesGzip(const http::Request& request) {
  const std::string accepted = request.Header("accept-encoding").value_or("");
  for (const absl::string_view coding : absl::StrSplit(accepted, ',')) {
    const absl::string_view name = coding.substr(0, coding.find(';'));
    if (absl::StripAsciiWhitespace(name) == "gzip") return !absl::StrContains(coding, "q=0");
  }
  return false;
}

}  // namespace

http::Response AnswerAsset(const http::Request& request, const Assets& assets) {
  if (request.method != "GET" && request.method != "HEAD") return WrongMethod("GET, HEAD");
  const std::string path = request.path == "/" ? kIndex : request.path;
  const auto asset =
      std::ranges::find_if(assets, [&path](const Asset& one) { return one.path == path; });
  if (asset == assets.end()) {
    if (path == kIndex) return http::Text(HttpCode(absl::StatusCode::kNotFound), kNotBuilt);
    return ErrorAnswer(absl::NotFoundError("there is nothing at this address"));
  }
  http::Response response;
  response.Set("Content-Type", asset->type);
  response.Set("Cache-Control", absl::StartsWith(path, kHashed)
                                    ? "public, max-age=31536000, immutable"
                                    : "no-cache");
  response.Set("Vary", "Accept-Encoding");
  const bool packed = !asset->gzip.empty() && TakesGzip(request);
  if (packed) response.Set("Content-Encoding", "gzip");
  response.body = std::string(packed ? asset->gzip : asset->content);
  return response;
}

}  // namespace isthmus::web
