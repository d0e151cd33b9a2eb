// The socket that a listener accepts its connections from.
#pragma once

#include <absl/status/statusor.h>

#include <string>

namespace isthmus::http {

struct ListeningSocket {
  int file = -1;  // Of whoever asked.
  int port = 0;
};

// At "host:port". Connections that say nothing stay with the system, see core/io/deferred_accept.h.
// Unavailable, with the system's words alone.
absl::StatusOr<ListeningSocket> ListenAt(const std::string& address);

}  // namespace isthmus::http
