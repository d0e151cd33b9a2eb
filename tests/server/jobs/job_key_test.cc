#include "server/jobs/job_key.h"

#include <gtest/gtest.h>

namespace isthmus::server {
namespace {

const SessionId kFirst("alice-1.2"), kSecond("b.o_b-12");  // NOLINT(cert-err58-cpp)

TEST(JobKeyTest, IsTheSameAfterItWasText) {
  for (const JobKey& key :
       {JobKey(MatchKey{{kFirst, kSecond}}), JobKey(IndexKey{kSecond}),
        JobKey(LoopKey{{kFirst, 7}}), JobKey(ShapeKey{kFirst}), JobKey(RevisitsKey())}) {
    EXPECT_EQ(ParseJobKey(ToText(key)), key) << ToText(key);
    EXPECT_EQ(ToText(key).find('\n'), std::string::npos);
  }
}

TEST(JobKeyTest, ReadsAsWords) {
  EXPECT_EQ(ToText(MatchKey{{kFirst, kSecond}}), "match alice-1.2 b.o_b-12");
  EXPECT_EQ(ToText(LoopKey{{kFirst, 7}}), "loops alice-1.2/7");
  EXPECT_EQ(Describe(MatchKey{{kFirst, kSecond}}), "the match of alice-1.2 and b.o_b-12");
  EXPECT_EQ(SessionsOf(MatchKey{{kFirst, kSecond}}), (std::vector<SessionId>{kFirst, kSecond}));
}

TEST(JobKeyTest, OtherTextsAreNone) {
  for (const char* text :
       {"", "match", "match alice-1", "match a b c", "loops alice-1", "loops alice-1/x", "index",
        "revisits alice-1", "the match of a and b"}) {
    EXPECT_FALSE(ParseJobKey(text).has_value()) << text;
  }
}

}  // namespace
}  // namespace isthmus::server
