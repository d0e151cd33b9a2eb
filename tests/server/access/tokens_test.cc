// Tokens on a disk: made, checked, revoked, damaged, and changed by another process.
#include "server/access/tokens.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <limits>
#include <set>
#include <thread>

#include "core/io/file_io.h"
#include "server/access/limits.h"

namespace isthmus::access {
namespace {

using testing::HasSubstr;

constexpr int64_t kSecond = 1'000'000'000;

class TokensTest : public testing::Test {
 protected:
  TokensTest() {
    std::string pattern = testing::TempDir() + "isthmus-tokens-XXXXXX";
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
    folder_ = pattern;
  }
  ~TokensTest() override { std::filesystem::remove_all(folder_); }

  std::unique_ptr<Tokens> Open() {
    auto tokens = Tokens::Open(
        folder_, [this](const std::string& problem) { problems_.push_back(problem); }, clock_);
    EXPECT_TRUE(tokens.ok()) << tokens.status();
    return *std::move(tokens);
  }
  static AccessToken Reader(const std::string& name, int64_t expires_ns = 0) {
    return {name, AccessRole::kReader, {}, {"default"}, 0, expires_ns, 0};
  }
  std::string Path() const { return folder_ + "/tokens"; }
  void NextLook() { clock_.Advance(kLookAgainNs); }

  std::string folder_;
  ManualClock clock_{1'790'000'000 * kSecond};
  std::vector<std::string> problems_;
};

TEST_F(TokensTest, ASecretIsLongAndRandomAndNotOnTheDisk) {
  const auto tokens = Open();
  EXPECT_FALSE(tokens->any());
  std::set<std::string> secrets;
  for (int k = 0; k < 20; ++k) {
    const auto made = tokens->Create(Reader("r" + std::to_string(k)));
    ASSERT_TRUE(made.ok()) << made.status();
    EXPECT_GE(made->secret.size(), 8 + 192 / 6u);
    secrets.insert(made->secret);
    EXPECT_THAT(*io::ReadFile(Path()), testing::Not(HasSubstr(made->secret.substr(8, 12))));
    EXPECT_EQ(tokens->Check(made->secret)->name, made->token.name);
  }
  EXPECT_EQ(secrets.size(), 20u);
  EXPECT_TRUE(tokens->any());
  struct stat state = {};
  ASSERT_EQ(stat(Path().c_str(), &state), 0);
  EXPECT_EQ(state.st_mode & 0777, 0600u);
}

TEST_F(TokensTest, OthersAreNone) {
  const auto tokens = Open();
  const std::string secret = tokens->Create(Reader("r"))->secret;
  for (const std::string& other :
       {std::string(), secret.substr(0, secret.size() - 1), secret + "A", std::string("r")}) {
    EXPECT_TRUE(absl::IsUnauthenticated(tokens->Check(other).status())) << other;
  }
}

TEST_F(TokensTest, OutliveTheProcess) {
  const std::string secret = Open()->Create(Reader("r"))->secret;
  const auto again = Open();
  EXPECT_EQ(again->Check(secret)->name, "r");
  EXPECT_EQ(again->List().size(), 1u);
  EXPECT_EQ(again->List()[0].created_ns, clock_.NowNs());
}

TEST_F(TokensTest, ExpireOnTheirDay) {
  const auto tokens = Open();
  const int64_t end_ns = clock_.NowNs() + 10 * kSecond;
  const std::string secret = tokens->Create(Reader("r", end_ns))->secret;
  clock_.Advance(10 * kSecond - 1);
  EXPECT_TRUE(tokens->Check(secret).ok());
  EXPECT_TRUE(tokens->StillHolds("r").ok());
  clock_.Advance(1);
  EXPECT_THAT(std::string(tokens->Check(secret).status().message()), HasSubstr("expired"));
  EXPECT_TRUE(absl::IsUnauthenticated(tokens->StillHolds("r")));
  for (const int64_t never_ns : {end_ns, int64_t{-1}, std::numeric_limits<int64_t>::min(),
                                 std::numeric_limits<int64_t>::max()}) {
    EXPECT_TRUE(absl::IsInvalidArgument(tokens->Create(Reader("s", never_ns)).status()));
  }
}

TEST_F(TokensTest, RevokedHoldNoMoreAndKeepTheirNames) {
  const auto tokens = Open();
  const std::string secret = tokens->Create(Reader("r"))->secret;
  EXPECT_TRUE(absl::IsAlreadyExists(tokens->Create(Reader("r")).status()));
  ASSERT_TRUE(tokens->Revoke("r").ok());
  EXPECT_THAT(std::string(tokens->Check(secret).status().message()), HasSubstr("revoked"));
  EXPECT_TRUE(tokens->any()) << "a server whose tokens are all revoked is not open";
  const int64_t revoked_ns = tokens->Revoke("r")->revoked_ns;
  clock_.Advance(5 * kSecond);
  EXPECT_EQ(tokens->Revoke("r")->revoked_ns, revoked_ns);
  EXPECT_TRUE(absl::IsAlreadyExists(tokens->Create(Reader("r")).status()));
  EXPECT_TRUE(absl::IsNotFound(tokens->Revoke("s").status()));
}

TEST_F(TokensTest, OfAnotherProcessAreSeenWithinASecond) {
  const auto server = Open();
  EXPECT_FALSE(server->any());
  const auto other = Open();
  const std::string secret = other->Create(Reader("r"))->secret;
  NextLook();
  EXPECT_TRUE(server->Check(secret).ok());
  ASSERT_TRUE(other->Revoke("r").ok());
  NextLook();
  EXPECT_TRUE(absl::IsUnauthenticated(server->Check(secret).status()));
  // Neither undoes what the other did.
  ASSERT_TRUE(server->Create(Reader("s")).ok());
  EXPECT_EQ(server->List().size(), 2u);
}

TEST_F(TokensTest, OfManyAtOnceNoneIsLost) {
  std::vector<std::thread> makers;
  makers.reserve(4);
  for (int k = 0; k < 4; ++k) {
    makers.emplace_back([this, k] {
      const auto tokens = Tokens::Open(folder_, nullptr, clock_);
      for (int n = 0; n < 10; ++n) {
        EXPECT_TRUE((*tokens)->Create(Reader(std::to_string(k * 10 + n))).ok());
      }
    });
  }
  for (std::thread& maker : makers) maker.join();
  EXPECT_EQ(Open()->List().size(), 40u);
}

TEST_F(TokensTest, ADamagedFileLetsNobodyInAndSaysWhatToDo) {
  ASSERT_TRUE(Open()->Create(Reader("r")).ok());
  std::string text = *io::ReadFile(Path());
  text[text.size() / 2] ^= 1;
  ASSERT_TRUE(io::WriteFile(Path(), text).ok());
  const auto tokens = Tokens::Open(folder_, nullptr, clock_);
  ASSERT_TRUE(absl::IsFailedPrecondition(tokens.status())) << tokens.status();
  EXPECT_THAT(std::string(tokens.status().message()), HasSubstr("isthmus token create --data"));
  ASSERT_TRUE(io::WriteFile(Path(), "").ok());
  EXPECT_FALSE(Tokens::Open(folder_, nullptr, clock_).ok()) << "an empty file is damaged, too";
}

TEST_F(TokensTest, DamageOrLossWhileOpenChangesNothing) {
  const auto tokens = Open();
  const std::string secret = tokens->Create(Reader("r"))->secret;
  ASSERT_TRUE(io::WriteFile(Path(), "rubbish").ok());
  NextLook();
  EXPECT_TRUE(tokens->Check(secret).ok());
  EXPECT_TRUE(absl::IsFailedPrecondition(tokens->Create(Reader("s")).status()));
  EXPECT_EQ(problems_.size(), 1u);
  std::filesystem::remove(Path());
  NextLook();
  EXPECT_TRUE(tokens->any()) << "a file that is gone opens nothing";
  EXPECT_TRUE(tokens->Check(secret).ok());
  EXPECT_EQ(problems_.size(), 2u);
  NextLook();
  EXPECT_TRUE(tokens->any());
  EXPECT_EQ(problems_.size(), 2u) << "said once";
}

}  // namespace
}  // namespace isthmus::access
