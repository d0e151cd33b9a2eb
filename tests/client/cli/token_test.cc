// isthmus token: on a folder, and over RPC.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "server/access/tokens.h"
#include "server/rpc/server.h"
#include "tests/client/cli/program.h"
#include "tests/server/rpc/fake_pipeline.h"

namespace isthmus::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class TokenCommandTest : public testing::Test {
 protected:
  TokenCommandTest() : folder_(ScratchFolder()) {}
  ~TokenCommandTest() override { std::filesystem::remove_all(folder_); }

  ProgramResult Token(const std::string& arguments) const {
    return Isthmus("token " + arguments + " --data " + folder_);
  }

  const std::string folder_;
};

TEST_F(TokenCommandTest, MakesListsAndRevokesInAFolder) {
  EXPECT_THAT(Token("list").out, HasSubstr("no tokens"));
  for (const char* what : {"list", "create --role admin --name chief", "revoke chief"}) {
    const ProgramResult mistyped =
        Isthmus(std::string("token ") + what + " --data " + folder_ + "/none");
    EXPECT_EQ(mistyped.code, 5) << what;
    EXPECT_THAT(mistyped.err, HasSubstr("no folder"));
    EXPECT_EQ(mistyped.out, "");
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ + "/none"));
  // gRPC would end the process.
  for (const char* odd : {"a\nb", "a\tb", "\xc3\xa4"}) {
    setenv("ISTHMUS_TOKEN", odd, 1);
    const ProgramResult refused = Isthmus("status --attempts 1 --server localhost:1");
    unsetenv("ISTHMUS_TOKEN");
    EXPECT_EQ(refused.code, 2);
    EXPECT_THAT(refused.err, HasSubstr("the token has a character"));
  }
  const ProgramResult chief = Token("create --role admin --name chief");
  ASSERT_EQ(chief.code, 0) << chief.err;
  EXPECT_THAT(chief.err, HasSubstr("cannot be shown again"));
  // The secret alone, for a file.
  const std::string secret = chief.out.substr(0, chief.out.find('\n'));
  EXPECT_EQ(chief.out, secret + "\n");
  const auto tokens = access::Tokens::Open(folder_);
  EXPECT_EQ((*tokens)->Check(secret)->name, "chief");
  EXPECT_EQ((*tokens)->Check(secret)->sites, std::vector<std::string>{"*"});

  const ProgramResult alice = Token("create --role robot --robot alice --expires 30d --json");
  ASSERT_EQ(alice.code, 0) << alice.err;
  const json made = json::parse(alice.out);
  EXPECT_EQ(made["version"], 2);
  EXPECT_EQ(made["token"]["name"], "alice");
  EXPECT_EQ(made["token"]["sites"], json({"default"}));
  EXPECT_EQ(made["token"]["role"], "ROLE_ROBOT");
  EXPECT_EQ(made["token"]["state"], "valid");
  EXPECT_NEAR(made["token"]["expires_ns"].get<double>() - made["token"]["created_ns"].get<double>(),
              30 * 86400e9, 2e9);
  EXPECT_GT(made["secret"].get<std::string>().size(), 40u);
  const json brief = json::parse(Token("create --role reader --name x --expires 90s --json").out);
  EXPECT_NEAR(
      brief["token"]["expires_ns"].get<double>() - brief["token"]["created_ns"].get<double>(), 90e9,
      2e9);

  EXPECT_EQ(Token("revoke alice").code, 0);
  const json list = json::parse(Token("list --json").out);
  EXPECT_EQ(list["version"], 2);
  ASSERT_EQ(list["tokens"].size(), 3u);
  EXPECT_EQ(list["tokens"][1]["state"], "revoked");
  EXPECT_EQ(Token("revoke nobody").code, 6);
}

TEST_F(TokenCommandTest, SaysWhatIsMissing) {
  const ProgramResult bare = Token("create --role robot --name x");
  EXPECT_NE(bare.code, 0);
  EXPECT_THAT(bare.err, HasSubstr("must name the robots"));
  EXPECT_EQ(Token("create --role king --name x").code, 2);
  EXPECT_EQ(Token("create --role reader").code, 2);
  const ProgramResult when = Token("create --role reader --name x --expires tomorrow");
  EXPECT_EQ(when.code, 2);
  EXPECT_THAT(when.err, HasSubstr("30d"));
  EXPECT_EQ(Token("list --server localhost:1").code, 2);
  EXPECT_THAT(Token("list").out, HasSubstr("no tokens"));
}

// The file of `token create > FILE` ends with a line break.
TEST_F(TokenCommandTest, ATokenCountsHoweverItComesAndIsNeverShown) {
  const ProgramResult chief = Token("create --role admin --name chief");
  const std::string secret = chief.out.substr(0, chief.out.find('\n'));
  ASSERT_GT(secret.size(), 40u);
  const auto tokens = access::Tokens::Open(folder_);
  rpc::FakePipeline pipeline;
  rpc::ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.tokens = tokens->get();
  const auto server = rpc::RpcServer::Start(&pipeline, options);
  ASSERT_TRUE(server.ok()) << server.status();
  const std::string at = " --attempts 1 --server " + (*server)->address();
  const std::string file = folder_ + "/chief.token";
  for (const char* end : {"", "\n", "\r\n", " \n\n"}) {
    std::ofstream(file) << secret << end;
    const ProgramResult by_file = Isthmus("token list --token-file " + file + at);
    EXPECT_EQ(by_file.code, 0) << by_file.err;
    setenv("ISTHMUS_TOKEN", (secret + end).c_str(), 1);
    const ProgramResult by_variable = Isthmus("token list" + at);
    unsetenv("ISTHMUS_TOKEN");
    EXPECT_EQ(by_variable.code, 0) << by_variable.err;
    EXPECT_EQ((by_file.out + by_file.err + by_variable.out + by_variable.err).find(secret),
              std::string::npos);
  }
  // Given in a way that is none, or in the wrong place.
  std::ofstream(file) << secret << "\n" << secret;
  setenv("GRPC_VERBOSITY", "ERROR", 1);
  for (const std::string& wrong :
       {"token list --token-file " + file, "token list --token-file " + secret,
        "token list --token " + secret, "token list " + secret, secret, "--site " + secret,
        "status --site " + secret, "token revoke " + secret, "session finish " + secret,
        "export -o " + secret + "/x.pcd", "push " + secret + " --robot alice",
        "status --tls-ca " + secret}) {
    const ProgramResult refused = Isthmus(wrong + at);
    EXPECT_NE(refused.code, 0) << wrong;
    EXPECT_EQ((refused.out + refused.err).find(secret.substr(8)), std::string::npos)
        << wrong << ": " << refused.out << refused.err;
  }
  unsetenv("GRPC_VERBOSITY");
}

TEST_F(TokenCommandTest, OverRpcTheFirstTokenClosesTheServer) {
  const auto tokens = access::Tokens::Open(folder_);
  rpc::FakePipeline pipeline;
  rpc::ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.tokens = tokens->get();
  const auto server = rpc::RpcServer::Start(&pipeline, options);
  ASSERT_TRUE(server.ok()) << server.status();
  const std::string at = " --server " + (*server)->address();
  const ProgramResult made = Isthmus("token create --role admin --name chief --json" + at);
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_EQ(json::parse(made.out)["token"]["sites"], json({"*"}));
  const ProgramResult refused = Isthmus("token list" + at);
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(refused.err, HasSubstr("asks for a token"));
}

TEST_F(TokenCommandTest, ABackupKeepsTheTokensIfAskedTo) {
  const ProgramResult chief = Token("create --role admin --name chief");
  const std::string secret = chief.out.substr(0, chief.out.find('\n'));
  const auto tokens = access::Tokens::Open(folder_);
  rpc::FakePipeline pipeline;
  rpc::ServerOptions options;
  options.listen = "127.0.0.1:0";
  options.tokens = tokens->get();
  options.backup = [](const rpc::BackupSink& sink) -> absl::StatusOr<BackupContents> {
    sink.begin(3);
    if (!sink.piece("abc")) return absl::CancelledError("given up");
    return BackupContents();
  };
  const auto server = rpc::RpcServer::Start(&pipeline, options);
  ASSERT_TRUE(server.ok()) << server.status();
  setenv("ISTHMUS_TOKEN", secret.c_str(), 1);
  const std::string at = " --server " + (*server)->address();
  const ProgramResult open = Isthmus("backup " + folder_ + "/open" + at);
  const ProgramResult closed = Isthmus("backup --tokens --json " + folder_ + "/closed" + at);
  unsetenv("ISTHMUS_TOKEN");
  EXPECT_EQ(open.code, 0) << open.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ + "/open/tokens"));
  ASSERT_EQ(closed.code, 0) << closed.err;
  EXPECT_EQ(json::parse(closed.out)["tokens"], true);
  const auto restored = access::Tokens::Open(folder_ + "/closed");
  ASSERT_TRUE(restored.ok()) << restored.status();
  EXPECT_EQ((*restored)->Check(secret)->name, "chief");
  EXPECT_EQ(std::filesystem::status(folder_ + "/closed/tokens").permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

}  // namespace
}  // namespace isthmus::cli
