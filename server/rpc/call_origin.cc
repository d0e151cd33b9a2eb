#include "server/rpc/call_origin.h"

#include <absl/strings/match.h>

#include <utility>

namespace isthmus::rpc {
namespace {

// The prefix of a peer names the socket that it came over.
bool IsWithinProcess(const std::string& peer) {
  return !absl::StartsWith(peer, "ipv4:") && !absl::StartsWith(peer, "ipv6:") &&
         !absl::StartsWith(peer, "unix") && !absl::StartsWith(peer, "vsock");
}

std::string PeerOf(const grpc::ServerContextBase& context) {
  std::string peer = context.peer();
  if (!IsWithinProcess(peer)) return peer;
  const auto named = context.client_metadata().find(kPeerHeader);
  if (named == context.client_metadata().end()) return peer;
  return std::string(named->second.data(), named->second.size());
}

}  // namespace

CallOrigin::CallOrigin(const grpc::ServerContextBase& context)
    : headers(context.client_metadata()),
      peer(PeerOf(context)),
      gone([&context] { return context.IsCancelled(); }),
      cancel([&context] { context.TryCancel(); }) {}

CallOrigin::CallOrigin(const Headers* all_headers, std::string its_peer,
                       std::function<bool()> is_gone)
    : headers(*all_headers), peer(std::move(its_peer)), gone(std::move(is_gone)) {}

}  // namespace isthmus::rpc
