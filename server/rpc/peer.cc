#include "server/rpc/peer.h"

#include <absl/strings/match.h>

namespace isthmus::rpc {
namespace {

// The prefix of a peer names the socket that it came over.
bool IsWithinProcess(const std::string& peer) {
  return !absl::StartsWith(peer, "ipv4:") && !absl::StartsWith(peer, "ipv6:") &&
         !absl::StartsWith(peer, "unix") && !absl::StartsWith(peer, "vsock");
}

}  // namespace

std::string PeerOf(const grpc::ServerContextBase& context) {
  std::string peer = context.peer();
  if (!IsWithinProcess(peer)) return peer;
  const auto named = context.client_metadata().find(kPeerHeader);
  if (named == context.client_metadata().end()) return peer;
  return std::string(named->second.data(), named->second.size());
}

}  // namespace isthmus::rpc
