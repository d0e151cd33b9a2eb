// One page over plain HTTP, made anew for each request.
#pragma once

#include <absl/status/statusor.h>

#include <functional>
#include <memory>
#include <string>

#include "server/http/listener.h"

namespace isthmus::metrics {

// Makes the page, from any thread. An exception is an answer of 500.
using PageContent = std::function<std::string()>;

// Answers GET and HEAD of /metrics at "host:port", port 0 for a free one, as long as what is
// returned lives; everything else is 404 or 405. Few at a time, each for a limited time; see
// limits.h. Errors of http::Listener::Start.
absl::StatusOr<std::unique_ptr<http::Listener>> ServePage(const std::string& listen,
                                                          const std::string& content_type,
                                                          PageContent content);

}  // namespace isthmus::metrics
