// A listener that takes connections only once something was said on them.
#pragma once

namespace isthmus::io {

// Has the system keep connections to the TCP port back from this process until their first bytes
// are there, some ten seconds at most (TCP_DEFER_ACCEPT): one that says nothing then costs neither
// a file nor time. One that is closed at once is accepted all the same, as its end counts for
// bytes. Clients of HTTP and of TLS speak first. Neither gRPC 1.51 nor CivetWeb has an option for
// it, so the listening sockets are looked for among the files of the process. Returns how many
// there were.
int DeferAccept(int port);

}  // namespace isthmus::io
