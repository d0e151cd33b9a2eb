#include "client/library/stream/unreachable.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace isthmus::client {
namespace {

using testing::HasSubstr;

// As gRPC 1.51 words them.
constexpr char kPrefix[] =
    "failed to connect to all addresses; last error: UNKNOWN: ipv4:1.2.3.4:5: ";

std::string Advice(const std::string& said, const std::string& ca) {
  ClientOptions options;
  options.tls.ca = ca;
  return AdviceOnUnreachable(options, kPrefix + said);
}

TEST(Unreachable, SaysWhatTheTwoDisagreeAbout) {
  EXPECT_THAT(Advice("Failed to connect to remote host: Connection refused", ""),
              HasSubstr("isthmus-server --data DIR --listen localhost:50051"));
  EXPECT_THAT(Advice("Socket closed", ""), HasSubstr("--tls-ca"));
  EXPECT_THAT(Advice("Connection reset by peer", ""), HasSubstr("--tls-ca"));
  EXPECT_THAT(
      Advice("Ssl handshake failed: error:0A00010B:SSL routines::wrong version number", "a"),
      HasSubstr("plain text"));
  EXPECT_THAT(Advice("SSL routines::certificate verify failed", "ca.pem"),
              HasSubstr("not signed by ca.pem"));
  EXPECT_THAT(Advice("Peer name localhost is not in peer certificate", "a"),
              HasSubstr("other hosts"));
  EXPECT_THAT(Advice("Socket closed", "a"), HasSubstr("--tls-cert"));
  EXPECT_THAT(Advice("Connection refused", "a"), HasSubstr("is it running, with TLS"));
}

TEST(Unreachable, OfSeveralServersOneHasToHaveTheMap) {
  ClientOptions options;
  options.address = "a:1,b:1";
  EXPECT_THAT(AdviceOnUnreachable(options, std::string(kPrefix) + "Connection refused"),
              HasSubstr("no server there has the map"));
}

}  // namespace
}  // namespace isthmus::client
