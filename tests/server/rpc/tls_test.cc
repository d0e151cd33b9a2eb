// TLS over a real socket: the clients that are let in, and changes while the server runs.
#include "server/rpc/tls.h"

#include <absl/time/clock.h>
#include <gmock/gmock.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "client/certificates/authority.h"
#include "client/library/client.h"
#include "core/io/file_io.h"
#include "core/tls/certificate.h"
#include "tests/server/rpc/fake_pipeline.h"

namespace isthmus::rpc {
namespace {

using testing::HasSubstr;

constexpr absl::Duration kMonth = absl::Hours(24 * 30);

class TlsTest : public testing::Test {
 protected:
  TlsTest() {
    char name[] = "/tmp/isthmus_tls_XXXXXX";
    folder_ = std::string(mkdtemp(name));
    const auto must = [](const absl::Status& status) {
      if (!status.ok()) throw std::runtime_error(std::string(status.message()));
    };
    must(certificates::MakeAuthority(folder_, kMonth));
    must(certificates::IssueServer(folder_, {"localhost", "127.0.0.1"}, kMonth));
    must(certificates::IssueClient(folder_, "alice", kMonth));
    options_.listen = "127.0.0.1:0";
    options_.tls.certificate = Path("server.pem");
    options_.tls.key = Path("server.key");
  }
  ~TlsTest() override { std::filesystem::remove_all(folder_); }

  std::string Path(const std::string& name) const { return folder_ + "/" + name; }

  void Start() {
    auto server = RpcServer::Start(&pipeline_, options_);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }

  // The first answer of a new connection.
  absl::Status Ask(const client::TlsOptions& tls) const {
    client::ClientOptions options;
    options.address = server_->address();
    options.tls = tls;
    options.backoff.max_attempts = 1;
    return client::Client::Connect(options).status();
  }
  client::TlsOptions Trusting() const {
    client::TlsOptions tls;
    tls.ca = Path("ca.pem");
    return tls;
  }
  client::TlsOptions Alice() const {
    client::TlsOptions tls = Trusting();
    tls.certificate = Path("alice.pem");
    tls.key = Path("alice.key");
    return tls;
  }
  // The exit code of openssl's client with these options.
  int Openssl(const std::string& options) const {
    const std::string command = "openssl s_client -connect " + server_->address() + " " + options +
                                " -alpn h2 </dev/null >" + Path("openssl.out") + " 2>&1";
    return std::system(command.c_str());
  }

  FakePipeline pipeline_;
  std::string folder_;
  ServerOptions options_;
  std::unique_ptr<RpcServer> server_;
};

TEST_F(TlsTest, LetsInWhoTrustsIt) {
  Start();
  EXPECT_TRUE(Ask(Trusting()).ok()) << Ask(Trusting());
  EXPECT_TRUE(Ask(Alice()).ok());             // Its certificate is not asked for.
  EXPECT_TRUE(absl::IsUnavailable(Ask({})));  // In plain text.
  client::TlsOptions system;
  system.ca = "system";
  EXPECT_TRUE(absl::IsUnavailable(Ask(system)));  // The system does not know the authority.
  client::TlsOptions other = Trusting();
  other.server_name = "other.example";
  EXPECT_TRUE(absl::IsUnavailable(Ask(other)));  // The certificate is for another name.
}

TEST_F(TlsTest, EachOfSeveralServersIsKnownByItsOwnName) {
  ASSERT_TRUE(certificates::IssueServer(folder_, {"localhost"}, kMonth).ok());
  Start();
  const std::string port = server_->address().substr(server_->address().rfind(':'));
  const std::string other = Path("other");
  std::filesystem::create_directories(other);
  for (const char* file : {"/ca.pem", "/ca.key"}) {
    std::filesystem::copy(folder_ + file, other + file);
  }
  ASSERT_TRUE(certificates::IssueServer(other, {"127.0.0.1"}, kMonth).ok());
  ServerOptions second_options = options_;
  second_options.tls.certificate = other + "/server.pem";
  second_options.tls.key = other + "/server.key";
  auto second = RpcServer::Start(&pipeline_, second_options);
  ASSERT_TRUE(second.ok()) << second.status();

  client::ClientOptions options;
  options.tls = Trusting();
  options.backoff.max_attempts = 1;
  options.address = "localhost" + port + "," + (*second)->address();
  const auto client = client::Client::Connect(options);
  ASSERT_TRUE(client.ok()) << client.status();
  server_->Shutdown(std::chrono::seconds(0));
  EXPECT_TRUE((*client)->GetMapInfo().ok());
  // Under a name that is not in its certificate none of them is taken.
  const std::string second_port = (*second)->address().substr((*second)->address().rfind(':'));
  options.address = "localhost" + port + ",localhost" + second_port;
  EXPECT_TRUE(absl::IsUnavailable(client::Client::Connect(options).status()));
}

TEST_F(TlsTest, AsksRobotsWhoTheyAre) {
  options_.tls.client_ca = Path("ca.pem");
  Start();
  EXPECT_TRUE(Ask(Alice()).ok()) << Ask(Alice());
  EXPECT_TRUE(absl::IsUnavailable(Ask(Trusting())));  // Without a certificate.
  const std::string other = Path("other");
  ASSERT_TRUE(certificates::MakeAuthority(other, kMonth).ok());
  ASSERT_TRUE(certificates::IssueClient(other, "alice", kMonth).ok());
  client::TlsOptions stranger = Trusting();
  stranger.certificate = other + "/alice.pem";
  stranger.key = other + "/alice.key";
  EXPECT_TRUE(absl::IsUnavailable(Ask(stranger)));
  client::TlsOptions server = Trusting();  // A certificate of the authority, but not a client's.
  server.certificate = Path("server.pem");
  server.key = Path("server.key");
  EXPECT_TRUE(absl::IsUnavailable(Ask(server)));
}

TEST_F(TlsTest, FilesThatCannotBeUsedAreToldByNameBeforeItConnects) {
  Start();
  EXPECT_TRUE(absl::IsNotFound(Ask({.ca = Path("none.pem")})));
  EXPECT_TRUE(absl::IsFailedPrecondition(Ask({.ca = folder_})));
  ASSERT_TRUE(io::WriteFile(Path("empty.pem"), "").ok());
  for (const char* file : {"server.key", "empty.pem"}) {
    const absl::Status status = Ask({.ca = Path(file)});
    EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
    EXPECT_THAT(status.message(), HasSubstr(Path(file) + " is no certificate"));
  }
  client::TlsOptions alice = Alice();
  alice.key = Path("server.key");
  EXPECT_THAT(Ask(alice).message(), HasSubstr("is not the key of"));
  alice.key.clear();
  EXPECT_TRUE(absl::IsInvalidArgument(Ask(alice)));
}

TEST_F(TlsTest, SpeaksNothingOlderThan12) {
  Start();
  EXPECT_EQ(Openssl("-tls1_2"), 0);
  EXPECT_EQ(Openssl("-tls1_3"), 0);
  EXPECT_NE(Openssl("-tls1_1 -cipher DEFAULT@SECLEVEL=0"), 0);
}

TEST_F(TlsTest, ShowsARenewedCertificateToNewConnections) {
  Start();
  client::ClientOptions options;
  options.address = server_->address();
  options.tls = Trusting();
  const auto old = client::Client::Connect(options);
  ASSERT_TRUE(old.ok()) << old.status();
  ASSERT_EQ(Openssl("-verify_hostname renewed.example -verify_return_error -CAfile " +
                    Path("ca.pem")) == 0,
            false);
  ASSERT_TRUE(
      certificates::IssueServer(folder_, {"renewed.example", "localhost", "127.0.0.1"}, kMonth)
          .ok());
  // It looks once a second; the attempts of a client wait in between.
  client::TlsOptions renewed = Trusting();
  renewed.server_name = "renewed.example";
  client::ClientOptions patient = options;
  patient.tls = renewed;
  patient.backoff.max_attempts = 60;
  patient.backoff.max_delay_s = 0.2;
  EXPECT_TRUE(client::Client::Connect(patient).ok());
  EXPECT_TRUE((*old)->GetMapInfo().ok());
}

// As a copy over a bad link, a full disk or a wrong file leave it. gRPC itself would abort of some.
TEST_F(TlsTest, GoesOnWithTheLastGoodFiles) {
  options_.tls.client_ca = Path("ca.pem");
  Start();
  const std::string certificate = *io::ReadFile(Path("server.pem"));
  client::TlsOptions alice = Alice();
  alice.ca = Path("trusted.pem");
  ASSERT_TRUE(io::WriteFile(alice.ca, *io::ReadFile(Path("ca.pem"))).ok());
  const auto write = [this](const char* name, const std::string& text) {
    ASSERT_TRUE(io::WriteFile(Path(name), text).ok());
  };
  for (const std::string& bad : {std::string(), certificate.substr(0, 300), std::string("\n")}) {
    for (const char* name : {"server.pem", "server.key", "ca.pem"}) write(name, bad);
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(2);
    while (std::chrono::steady_clock::now() < until) {  // It looks once a second, gRPC likewise.
      ASSERT_TRUE(Ask(alice).ok()) << Ask(alice);
    }
  }
  write("server.pem", certificate);
  write("server.key", *io::ReadFile(Path("alice.key")));
  write("ca.pem", *io::ReadFile(alice.ca));
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(2);
  while (std::chrono::steady_clock::now() < until) {
    ASSERT_TRUE(Ask(alice).ok()) << Ask(alice);
  }
}

TEST_F(TlsTest, ARefusedPairIsNamedAtTheStart) {
  options_.tls.key = Path("ca.key");
  EXPECT_THAT(RpcServer::Start(&pipeline_, options_).status().message(),
              HasSubstr("is not the key of"));
  options_.tls.key = "";
  EXPECT_THAT(RpcServer::Start(&pipeline_, options_).status().message(), HasSubstr("set both"));
  options_.tls = {"", "", Path("ca.pem")};
  EXPECT_THAT(RpcServer::Start(&pipeline_, options_).status().message(),
              HasSubstr("tls_certificate"));
}

TEST_F(TlsTest, PlainTextForOtherMachinesMustBeSpelledOut) {
  for (const char* listen : {"0.0.0.0:0", "[::]:0", "192.168.1.2:0", "robots.example:0"}) {
    ServerOptions plain;
    plain.listen = listen;
    EXPECT_THAT(CheckListening(plain).message(), HasSubstr("--insecure")) << listen;
    plain.insecure = true;
    EXPECT_TRUE(CheckListening(plain).ok());
    plain.insecure = false;
    plain.tls = options_.tls;
    EXPECT_TRUE(CheckListening(plain).ok());
  }
  for (const char* listen : {"127.0.0.1:0", "127.8.0.1:1", "[::1]:0", "localhost:0", "unix:/a"}) {
    ServerOptions plain;
    plain.listen = listen;
    EXPECT_TRUE(CheckListening(plain).ok()) << listen;
  }
  ServerOptions plain;
  plain.listen = "0.0.0.0:0";
  EXPECT_TRUE(absl::IsFailedPrecondition(RpcServer::Start(&pipeline_, plain).status()));
}

}  // namespace
}  // namespace isthmus::rpc
