// Plain connections to a server, below gRPC.
#pragma once

#include <string>

namespace isthmus::loadgen {

// A connected socket to "host:port" or "unix:PATH"; -1 where nobody listens. The caller closes it.
int Dial(const std::string& server);

// Closes so that the other end sees a reset, not an end.
void HangUp(int socket);

}  // namespace isthmus::loadgen
