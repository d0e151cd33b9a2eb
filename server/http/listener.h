// A listener for HTTP/1.1, in plain text or with TLS, that bounds the resources its clients can
// hold.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "core/tls/key_files.h"
#include "server/http/exchange.h"
#include "server/http/limits.h"

namespace isthmus::http {

struct ListenerOptions {
  std::string listen;   // "host:port", port 0 takes a free one.
  std::string setting;  // The name of that setting, for people: "metrics.listen".
  // Read again within a second of a change: new connections see the new certificate, open ones go
  // on.
  tls::KeyFiles tls = {};
  // Each is served by a thread of its own. Further ones wait, without a word.
  size_t connections = 128;
  size_t connections_per_address = 64;  // Further ones are closed.
  size_t max_body = size_t{1} << 20;    // Bytes; beyond, 413.
  std::chrono::milliseconds request_time = kRequestTime;
  std::chrono::milliseconds piece_time = kPieceTime;
};

// Errors for a person to put right before a start: InvalidArgument where `listen` is no address of
// TCP.
absl::Status CheckTcpAddress(const std::string& setting, const std::string& listen);

// Thread safe.
class Listener {
 public:
  // Answers one request, on the thread of its connection; an exception is an answer of 500.
  using Handler = std::function<Response(const Request&)>;

  // Unavailable, saying why, where it cannot listen; FailedPrecondition where the files are no key
  // pair.
  static absl::StatusOr<std::unique_ptr<Listener>> Start(const ListenerOptions& options,
                                                         Handler handler);
  // Closes connections; waits for handlers, to which their clients are gone.
  virtual ~Listener() = default;

  // With the port filled in.
  virtual std::string address() const = 0;
};

}  // namespace isthmus::http
