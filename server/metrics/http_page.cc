#include "server/metrics/http_page.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "server/metrics/limits.h"

namespace isthmus::metrics {
namespace {

constexpr char kPath[] = "/metrics";

http::Response Answer(const http::Request& request, const std::string& content_type,
                      const PageContent& content) {
  if (request.path != kPath) {
    return http::Text(404, absl::StrCat("the metrics are at ", kPath, "\n"));
  }
  if (request.method != "GET" && request.method != "HEAD") {
    return http::Text(405, "the metrics can be read alone\n");
  }
  http::Response response;
  response.Set("Content-Type", content_type);
  response.body = content();
  return response;
}

}  // namespace

absl::StatusOr<std::unique_ptr<http::Listener>> ServePage(const std::string& listen,
                                                          const std::string& content_type,
                                                          PageContent content) {
  http::ListenerOptions options;
  options.listen = listen;
  options.setting = "metrics.listen";
  options.connections = options.connections_per_address = kHttpConnections;
  options.request_time = options.piece_time = kHttpTime;
  return http::Listener::Start(
      options, [content_type, content = std::move(content)](const http::Request& request) {
        http::Response response = Answer(request, content_type, content);
        response.Set("Cache-Control", "no-store");
        response.Set("Connection", "close");  // The next scrape is seconds away.
        return response;
      });
}

}  // namespace isthmus::metrics
