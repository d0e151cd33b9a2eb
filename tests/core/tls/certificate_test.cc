#include "core/tls/certificate.h"

#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <filesystem>

#include "client/certificates/authority.h"
#include "core/io/file_io.h"
#include "core/tls/key_files.h"

namespace isthmus::tls {
namespace {

using certificates::IssueClient;
using certificates::IssueServer;
using certificates::MakeAuthority;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr absl::Duration kYear = absl::Hours(24 * 365);

class CertificateTest : public testing::Test {
 protected:
  CertificateTest() {
    char name[] = "/tmp/isthmus_certs_XXXXXX";
    folder_ = std::string(mkdtemp(name));
  }
  ~CertificateTest() override { std::filesystem::remove_all(folder_); }

  std::string Path(const std::string& name) const { return folder_ + "/" + name; }

  std::string folder_;
};

// By another program than the one that made it.
bool OpensslVerifies(const std::string& folder, const std::string& name,
                     const std::string& purpose) {
  const std::string command = "openssl verify -x509_strict -purpose " + purpose + " -CAfile " +
                              folder + "/ca.pem " + folder + "/" + name + ".pem >/dev/null 2>&1";
  return std::system(command.c_str()) == 0;
}

TEST_F(CertificateTest, OfTheAuthorityAreVerified) {
  ASSERT_TRUE(MakeAuthority(folder_, kYear).ok());
  ASSERT_TRUE(IssueServer(folder_, {"map.example", "192.168.1.2", "::1"}, kYear).ok());
  ASSERT_TRUE(IssueClient(folder_, "alice", kYear).ok());
  EXPECT_TRUE(OpensslVerifies(folder_, "server", "sslserver"));
  EXPECT_TRUE(OpensslVerifies(folder_, "alice", "sslclient"));
  EXPECT_FALSE(OpensslVerifies(folder_, "alice", "sslserver"));  // A robot cannot play the server.

  const auto server = ReadCertificate(Path("server.pem"));
  ASSERT_TRUE(server.ok()) << server.status();
  EXPECT_EQ(server->subject, "map.example");
  EXPECT_THAT(server->names, ElementsAre("map.example", "192.168.1.2", "::1"));
  EXPECT_FALSE(server->is_authority);
  EXPECT_NEAR(absl::ToDoubleHours(server->not_after - absl::Now()), 24 * 365, 1);
  EXPECT_LT(server->not_before, absl::Now());
  EXPECT_EQ(ReadCertificate(Path("ca.pem"))->is_authority, true);
}

TEST_F(CertificateTest, KeysAreTheirOwnersAlone) {
  ASSERT_TRUE(MakeAuthority(folder_, kYear).ok());
  ASSERT_TRUE(IssueServer(folder_, {"localhost"}, kYear).ok());
  for (const char* name : {"ca.key", "server.key"}) {
    struct stat state = {};
    ASSERT_EQ(stat(Path(name).c_str(), &state), 0);
    EXPECT_EQ(state.st_mode & 0777, 0600u) << name;
  }
  EXPECT_TRUE(ReadKeyFiles({Path("server.pem"), Path("server.key")}).ok());
  chmod(Path("server.key").c_str(), 0644);
  EXPECT_THAT(ReadKeyFiles({Path("server.pem"), Path("server.key")}).status().message(),
              HasSubstr("chmod 600"));
}

TEST_F(CertificateTest, WhatIsNoPairIsRefused) {
  ASSERT_TRUE(MakeAuthority(folder_, kYear).ok());
  ASSERT_TRUE(IssueServer(folder_, {"localhost"}, kYear).ok());
  EXPECT_THAT(ReadKeyFiles({Path("server.pem"), Path("ca.key")}).status().message(),
              HasSubstr("is not the key of"));
  EXPECT_THAT(ReadKeyFiles({Path("server.key"), Path("server.key")}).status().message(),
              HasSubstr("is no certificate"));
  EXPECT_THAT(ReadKeyFiles({Path("server.pem"), Path("server.pem")}).status().message(),
              HasSubstr("no private key"));
  EXPECT_TRUE(absl::IsNotFound(ReadKeyFiles({Path("none.pem"), Path("server.key")}).status()));
  ASSERT_TRUE(io::WriteFile(Path("empty.pem"), "").ok());
  EXPECT_THAT(ReadKeyFiles({Path("empty.pem"), Path("server.key")}).status().message(),
              HasSubstr("is no certificate"));
  // A chain of two, of which the second is cut off.
  const std::string whole = *io::ReadFile(Path("server.pem"));
  ASSERT_TRUE(io::WriteFile(Path("cut.pem"), whole + whole.substr(0, whole.size() / 2)).ok());
  EXPECT_THAT(ReadKeyFiles({Path("cut.pem"), Path("server.key")}).status().message(),
              HasSubstr("cut off"));
  ASSERT_TRUE(io::WriteFile(Path("chain.pem"), whole + *io::ReadFile(Path("ca.pem"))).ok());
  EXPECT_TRUE(ReadKeyFiles({Path("chain.pem"), Path("server.key"), Path("ca.pem")}).ok());
}

// The DER bytes in a PEM file, and back.
std::string DerOf(const std::string& pem) {
  const size_t begin = pem.find('\n') + 1;
  std::string der;
  EXPECT_TRUE(absl::Base64Unescape(pem.substr(begin, pem.find("-----END") - begin), &der));
  return der;
}

std::string PemOf(const std::string& der) {
  std::string pem = "-----BEGIN CERTIFICATE-----\n";
  const std::string text = absl::Base64Escape(der);
  for (size_t at = 0; at < text.size(); at += 64) absl::StrAppend(&pem, text.substr(at, 64), "\n");
  return pem + "-----END CERTIFICATE-----\n";
}

TEST_F(CertificateTest, AnAddressOfTwoBytesIsNone) {
  ASSERT_TRUE(MakeAuthority(folder_, kYear).ok());
  ASSERT_TRUE(IssueServer(folder_, {"map.example", "192.168.1.2"}, kYear).ok());
  std::string der = DerOf(*io::ReadFile(Path("server.pem")));
  const size_t at = der.find("\x87\x04\xc0\xa8\x01\x02");
  ASSERT_NE(at, std::string::npos);
  // An address of two bytes, then a mail address of none.
  der.replace(at, 6, std::string("\x87\x02\xc0\xa8\x81\x00", 6));
  const auto certificate = ParseCertificate(PemOf(der));
  ASSERT_TRUE(certificate.ok()) << certificate.status();
  EXPECT_THAT(certificate->names, ElementsAre("map.example"));
}

TEST_F(CertificateTest, AnAuthorityIsNotReplaced) {
  ASSERT_TRUE(MakeAuthority(folder_, kYear).ok());
  const std::string before = *io::ReadFile(Path("ca.pem"));
  EXPECT_TRUE(absl::IsAlreadyExists(MakeAuthority(folder_, kYear)));
  EXPECT_EQ(*io::ReadFile(Path("ca.pem")), before);
}

TEST_F(CertificateTest, NamesThatMeanSomethingElseAreRefused) {
  ASSERT_TRUE(MakeAuthority(folder_, kYear).ok());
  for (const char* name : {"", "ca", "server", "../alice", "a/b", ".hidden", "a,DNS:b"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(IssueClient(folder_, name, kYear))) << name;
  }
  for (const char* host : {"", "a b", "a,DNS:evil", "copy:1"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(IssueServer(folder_, {host}, kYear))) << host;
  }
  EXPECT_TRUE(absl::IsInvalidArgument(IssueServer(folder_, {}, kYear)));
  EXPECT_TRUE(absl::IsNotFound(IssueClient(folder_ + "/none", "alice", kYear)));
}

}  // namespace
}  // namespace isthmus::tls
