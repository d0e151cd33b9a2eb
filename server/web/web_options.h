// The settings of the service to browsers.
#pragma once

#include <absl/status/status.h>

#include <string>

#include "server/http/listener.h"

namespace isthmus::web {

struct WebOptions {
  std::string listen = {};  // "host:port", port 0 takes a free one; empty: nothing is served.
  // True if an address that other machines reach may be served in plain text.
  bool insecure = false;
  // Names, separated by spaces, that something in front of the server is reached by.
  std::string hosts = {};
  tls::KeyFiles tls = {};  // The server's own.
};

// Errors for a person to put right before a start: InvalidArgument where the address is none of
// TCP, FailedPrecondition where others than this machine reach it in plain text and `insecure` does
// not say that they may.
absl::Status CheckListening(const WebOptions& options);

}  // namespace isthmus::web
