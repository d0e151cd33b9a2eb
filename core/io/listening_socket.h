// Sockets at which connections come in.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "core/io/file_io.h"

namespace isthmus::io {

// Listens at all addresses of "host:port", which CheckAddress lets pass; every address of the
// machine, as "0.0.0.0" or "[::]", is both of IPv4 and IPv6. Port 0 takes a free one. The sockets
// do not block. The system keeps a connection back until its first bytes are there, some ten
// seconds at most (TCP_DEFER_ACCEPT): one that says nothing costs neither a file nor time, as
// clients of HTTP and of TLS speak first. Unavailable, with the system's words alone, where one of
// them is in use or none is of this machine.
absl::StatusOr<std::vector<File>> ListenAt(const std::string& address);

// The port of an IPv4 or IPv6 socket.
int PortOf(const File& socket);

}  // namespace isthmus::io
