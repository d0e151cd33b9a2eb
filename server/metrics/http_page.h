// One page over plain HTTP, made anew for whoever asks.
#pragma once

#include <absl/status/statusor.h>

#include <functional>
#include <memory>
#include <string>

namespace isthmus::metrics {

// Answers GET and HEAD of /metrics; everything else is 404 or 405. Few at a time, each for a
// limited time; see limits.h. Thread safe.
class HttpPage {
 public:
  // Makes the page, from any thread. What it throws is an answer of 500.
  using Content = std::function<std::string()>;

  // Listens at "host:port"; port 0 takes a free one. Unavailable, saying why, where it cannot.
  static absl::StatusOr<std::unique_ptr<HttpPage>> Serve(const std::string& listen,
                                                         const std::string& content_type,
                                                         Content content);
  // Ends answers under way.
  virtual ~HttpPage() = default;

  // With the port filled in.
  virtual std::string address() const = 0;
};

}  // namespace isthmus::metrics
