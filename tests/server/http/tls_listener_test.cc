// The listener with TLS, as OpenSSL's own client finds it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "client/certificates/authority.h"
#include "core/io/file_io.h"
#include "core/io/part_file.h"
#include "core/tls/certificate.h"
#include "server/http/listener.h"
#include "tests/server/http/conversation.h"

namespace isthmus::http {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr absl::Duration kMonth = absl::Hours(24 * 30);

class TlsListenerTest : public testing::Test {
 protected:
  TlsListenerTest() {
    folder_ = testing::TempDir() + "isthmus-https-XXXXXX";
    if (mkdtemp(folder_.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
    Must(certificates::MakeAuthority(folder_, kMonth));
    Must(certificates::IssueServer(folder_, {"localhost", "127.0.0.1"}, kMonth));
    options_.listen = "127.0.0.1:0";
    options_.tls.certificate = Path("server.pem");
    options_.tls.key = Path("server.key");
  }
  ~TlsListenerTest() override { std::filesystem::remove_all(folder_); }

  static void Must(const absl::Status& status) {
    if (!status.ok()) throw std::runtime_error(std::string(status.message()));
  }
  std::string Path(const std::string& name) const { return folder_ + "/" + name; }
  void Start() {
    auto started = Listener::Start(options_, [](const Request& request) {
      return Text(200, request.is_tls ? "over TLS" : "in plain text");
    });
    ASSERT_TRUE(started.ok()) << started.status();
    listener_ = *std::move(started);
  }
  // The answer to a request over a connection of openssl's client with these options.
  std::string Openssl(const std::string& options) const {
    const std::string command =
        "printf 'GET / HTTP/1.1\\r\\nHost: localhost\\r\\nConnection: close\\r\\n\\r\\n' | "
        "timeout 20 openssl s_client -ign_eof -connect " +
        listener_->address() + " -CAfile " + Path("ca.pem") + " -verify_return_error " + options +
        " >" + Path("out") + " 2>&1";
    std::system(command.c_str());
    return io::ReadFile(Path("out")).value_or("");
  }

  std::string folder_;
  ListenerOptions options_;
  std::unique_ptr<Listener> listener_;
};

TEST_F(TlsListenerTest, SpeaksTlsFrom12OnAndNothingElse) {
  Start();
  EXPECT_THAT(Openssl("-tls1_2"), HasSubstr("over TLS"));
  EXPECT_THAT(Openssl("-tls1_3"), HasSubstr("over TLS"));
  EXPECT_THAT(Openssl("-tls1_1 -cipher DEFAULT@SECLEVEL=0"), Not(HasSubstr("over TLS")));
  EXPECT_EQ(Ask(listener_->address(), "GET", "/").code, 0);
}

TEST_F(TlsListenerTest, NewConnectionsSeeARenewedCertificate) {
  Start();
  const auto serial = [this] {
    const std::string out = Openssl("-showcerts");
    const size_t begin = out.find("-----BEGIN"), end = out.find("-----END");
    return begin == std::string::npos ? out : out.substr(begin, end - begin);
  };
  const std::string before = serial();
  ASSERT_THAT(before, HasSubstr("BEGIN CERTIFICATE"));
  Must(certificates::IssueServer(folder_, {"localhost", "127.0.0.1"}, kMonth));
  std::string after = before;
  for (int i = 0; i < 100 && after == before; ++i) after = serial();  // It looks twice a second.
  EXPECT_NE(after, before);
  EXPECT_THAT(Openssl(""), HasSubstr("over TLS"));
  // A file that is none changes nothing.
  ASSERT_TRUE(io::ReplaceFile(Path("server.pem"), "no certificate").ok());
  for (int i = 0; i < 20; ++i) EXPECT_EQ(serial(), after);
}

TEST_F(TlsListenerTest, AsksForCertificatesWhereThereIsAnAuthorityOfClients) {
  Must(certificates::IssueClient(folder_, "alice", kMonth));
  Must(certificates::MakeAuthority(Path("other"), kMonth));
  Must(certificates::IssueClient(Path("other"), "mallory", kMonth));
  options_.tls.client_ca = Path("ca.pem");
  Start();
  const auto shown = [this](const std::string& name) {
    return Openssl("-cert " + Path(name + ".pem") + " -key " + Path(name + ".key"));
  };
  EXPECT_THAT(shown("alice"), HasSubstr("over TLS"));
  EXPECT_THAT(Openssl(""), Not(HasSubstr("over TLS")));
  EXPECT_THAT(shown("other/mallory"), Not(HasSubstr("over TLS")));
  EXPECT_THAT(shown("server"), Not(HasSubstr("over TLS")));  // By the authority, but no client's.
}

TEST_F(TlsListenerTest, FilesThatAreNoKeyPairEndTheStart) {
  options_.tls.key = Path("ca.key");
  EXPECT_TRUE(absl::IsFailedPrecondition(
      Listener::Start(options_, [](const Request&) { return Response(); }).status()));
  options_.tls.key = "";
  EXPECT_TRUE(absl::IsInvalidArgument(
      Listener::Start(options_, [](const Request&) { return Response(); }).status()));
}

}  // namespace
}  // namespace isthmus::http
