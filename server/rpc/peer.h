// The peer of a call: who is at the other end, however the call came here.
#pragma once

#include <grpcpp/server_context.h>

#include <string>

namespace isthmus::rpc {

// Header by which a part of this process that passes calls on for others names their peer, as gRPC
// does. Believed of calls within the process alone (RpcServer::InProcessChannel).
inline constexpr char kPeerHeader[] = "isthmus-peer";

// As gRPC names it: "ipv4:127.0.0.1:4711".
std::string PeerOf(const grpc::ServerContextBase& context);

}  // namespace isthmus::rpc
