#include "client/library/stream/unreachable.h"

#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>

namespace isthmus::client {
namespace {

constexpr char kSeveral[] =
    "no server there has the map: is one running, and does it reach its database?";

}  // namespace

std::string AdviceOnUnreachable(const ClientOptions& options, const std::string& message) {
  const std::string said = absl::AsciiStrToLower(message);
  const bool is_cut =
      absl::StrContains(said, "socket closed") || absl::StrContains(said, "reset by peer");
  if (options.tls.ca.empty()) {
    // One that wants TLS hangs up on plain text, and so may one that stops.
    if (is_cut)
      return "it closed the connection: does it speak TLS? Then give the CA's certificate "
             "(--tls-ca FILE). Or does something on the way to it cut the link?";
    if (absl::StrContains(options.address, ',')) return kSeveral;
    return absl::StrCat("is it running? Start it with `isthmus-server --data DIR --listen ",
                        options.address, "`");
  }
  if (absl::StrContains(said, "wrong version number")) {
    return "it speaks plain text: leave the CA's certificate out, or have it serve with TLS";
  }
  if (absl::StrContains(said, "certificate verify failed")) {
    return absl::StrCat("its certificate has expired, or was not signed by ", options.tls.ca,
                        ": `isthmus certs show` says until when one is valid");
  }
  if (absl::StrContains(said, "is not in peer certificate")) {
    return "its certificate is for other hosts: use one of those names, or sign another "
           "certificate (`isthmus certs renew`, `add --host`)";
  }
  if (is_cut) {
    return "it closed the connection: does it require a client certificate (--tls-cert, "
           "--tls-key), and trust its signer?";
  }
  return absl::StrContains(options.address, ',') ? kSeveral : "is it running, with TLS?";
}

}  // namespace isthmus::client
