// The origin of a call: what its caller sent beside the request, and whether it is still there.
#pragma once

#include <grpcpp/server_context.h>

#include <functional>
#include <map>
#include <string>

namespace isthmus::rpc {

// Header by which a part of this process that passes calls on for others names their peer, as gRPC
// does. Believed of calls within the process alone (RpcServer::InProcessChannel).
inline constexpr char kPeerHeader[] = "isthmus-peer";

struct CallOrigin {
  using Headers = std::multimap<grpc::string_ref, grpc::string_ref>;

  // Over gRPC. The context must outlive the call.
  CallOrigin(const grpc::ServerContextBase& context);  // NOLINT(google-explicit-constructor)
  // By another way. The headers, with names in lower case, must outlive this, but not the call.
  // `gone` is asked from the thread that answers the call.
  CallOrigin(const Headers* all_headers, std::string its_peer, std::function<bool()> is_gone);

  const Headers& headers;
  const std::string peer;  // As gRPC names it: "ipv4:127.0.0.1:4711".
  const std::function<bool()> gone;
  // Ends a call that waits for its caller; null where none does.
  const std::function<void()> cancel;
};

}  // namespace isthmus::rpc
