// The file's text: it is read back as it was, and no damage goes unnoticed.
#include "server/access/token_text.h"

#include <gtest/gtest.h>

namespace isthmus::access {
namespace {

StoredToken Robot() {
  return {{"alice-2026",
           AccessRole::kRobot,
           {"alice", "-", "cart-*"},
           {"default", "yard*"},
           1'700'000'000'000'000'000,
           1'800'000'000'000'000'000,
           0},
          std::string(31, '\x8f') + '\0'};
}

StoredToken Admin() {
  return {{"chief",
           AccessRole::kAdmin,
           {},
           {"*"},
           1'700'000'001'000'000'000,
           0,
           1'700'000'002'000'000'000},
          std::string(32, 'x')};
}

TEST(TokenText, ComesBackAsItWas) {
  const auto tokens = ParseTokens(PrintTokens({Robot(), Admin()}));
  ASSERT_TRUE(tokens.ok()) << tokens.status();
  ASSERT_EQ(tokens->size(), 2u);
  EXPECT_EQ((*tokens)[0].token, Robot().token);
  EXPECT_EQ((*tokens)[0].hash, Robot().hash);
  EXPECT_EQ((*tokens)[1].token, Admin().token);
  EXPECT_EQ(ParseTokens(PrintTokens({}))->size(), 0u);
}

TEST(TokenText, EveryFlippedBitAndEveryCutIsFound) {
  const std::string text = PrintTokens({Robot(), Admin()});
  for (size_t at = 0; at < text.size(); ++at) {
    for (const int bit : {1, 16}) {
      std::string damaged = text;
      damaged[at] = static_cast<char>(damaged[at] ^ bit);
      EXPECT_FALSE(ParseTokens(damaged).ok()) << at;
    }
    EXPECT_FALSE(ParseTokens(text.substr(0, at)).ok()) << at;
  }
  EXPECT_FALSE(ParseTokens(text + "\n").ok());
}

TEST(TokenText, OfANewerVersionIsSaidToBe) {
  const auto tokens = ParseTokens("isthmus-tokens 2\nwho knows what\n");
  EXPECT_TRUE(absl::IsFailedPrecondition(tokens.status())) << tokens.status();
}

TEST(TokenText, WhatCannotBeKeptIsRefused) {
  const auto refused = [](auto change) {
    AccessToken token = Robot().token;
    change(token);
    return absl::IsInvalidArgument(CheckToken(token));
  };
  EXPECT_TRUE(CheckToken(Robot().token).ok());
  EXPECT_TRUE(refused([](AccessToken& t) { t.name = ""; }));
  EXPECT_TRUE(refused([](AccessToken& t) { t.name = "two words"; }));
  EXPECT_TRUE(refused([](AccessToken& t) { t.name = "stars*"; }));
  EXPECT_TRUE(refused([](AccessToken& t) { t.name = std::string(65, 'a'); }));
  EXPECT_TRUE(refused([](AccessToken& t) { t.robots = {}; }));
  EXPECT_TRUE(refused([](AccessToken& t) { t.robots = {"a,b"}; }));
  EXPECT_TRUE(refused([](AccessToken& t) { t.robots = {"a\ntoken mallory role=admin"}; }));
  EXPECT_TRUE(refused([](AccessToken& t) { t.robots.assign(101, "a"); }));
  EXPECT_TRUE(refused([](AccessToken& t) { t.sites = {}; }));
  EXPECT_TRUE(refused([](AccessToken& t) { t.sites = {""}; }));
  EXPECT_TRUE(refused([](AccessToken& t) { t.role = AccessRole::kAdmin; })) << "it has robots";
  EXPECT_FALSE(refused([](AccessToken& t) { t.role = AccessRole::kReader; }));
}

TEST(TokenText, ASecretIsNoName) {
  AccessToken token;
  token.name = "isthmus_" + std::string(43, 'x');
  token.sites = {"*"};
  token.role = AccessRole::kReader;
  EXPECT_TRUE(absl::IsInvalidArgument(CheckToken(token)));
  token.name = "isthmus_reader";
  EXPECT_TRUE(CheckToken(token).ok());
}

}  // namespace
}  // namespace isthmus::access
