// Text of others, cut, escaped and made valid.
#include "core/plain_text.h"

#include <gtest/gtest.h>

namespace isthmus {
namespace {

TEST(PlainText, ALineHoldsNothingThatATerminalObeys) {
  EXPECT_EQ(LineOf("alice \xc3\xa4", 100), "alice \xc3\xa4");
  EXPECT_EQ(LineOf("a\nb\r\t\x1b[31m\x7f\xc2\x9b", 100),
            "a\\x0ab\\x0d\\x09\\x1b[31m\\x7f\\xc2\\x9b");
  EXPECT_EQ(LineOf("a\xe2\x80\xae"
                   "b\xe2\x81\xa6\xe2\x82\xac",
                   100),
            "a\\xe2\\x80\\xaeb\\xe2\\x81\\xa6\xe2\x82\xac");
  EXPECT_EQ(LineOf("abcdef", 3), "abc...");
  EXPECT_EQ(LineOf("ab\n", 4), "ab...");  // No half of an escape.
}

TEST(PlainText, ALineHoldsNoSecretOfAToken) {
  const std::string secret = "isthmus_" + std::string(20, 'A') + "-_" + std::string(21, '9');
  EXPECT_EQ(LineOf("no file " + secret + ": see " + secret, 100),
            "no file isthmus_...: see isthmus_...");
  EXPECT_EQ(LineOf(secret, 10), "isthmus_.....");
  EXPECT_EQ(LineOf("isthmus_hall_2 isthmus_", 100), "isthmus_hall_2 isthmus_");
}

TEST(PlainText, CutTextKeepsCharactersWhole) {
  EXPECT_EQ(CutText("abc", 3), "abc");
  EXPECT_EQ(CutText("abc", 2), "ab");
  EXPECT_EQ(CutText("a\xc3\xa4"
                    "b",
                    2),
            "a");
  EXPECT_EQ(CutText("a\xc3\xa4"
                    "b",
                    3),
            "a\xc3\xa4");
}

TEST(PlainText, ValidUtf8KeepsWhatIsAndReplacesWhatIsNot) {
  const std::string good = "a\xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80\xf4\x8f\xbf\xbf";
  EXPECT_EQ(ValidUtf8(good), good);
  EXPECT_TRUE(IsUtf8(good));
  EXPECT_TRUE(IsUtf8(""));
  EXPECT_FALSE(IsUtf8("bad\xff"));
  EXPECT_FALSE(IsUtf8("\xc3"));
  EXPECT_EQ(ValidUtf8("\xff"
                      "a\xc3"),
            "?a?");
  EXPECT_EQ(ValidUtf8("\xc0\x80"), "??");            // Longer than need be.
  EXPECT_EQ(ValidUtf8("\xe0\x9f\xbf"), "???");       // Overlong, too.
  EXPECT_EQ(ValidUtf8("\xed\xa0\x80"), "???");       // Half of a pair.
  EXPECT_EQ(ValidUtf8("\xf4\x90\x80\x80"), "????");  // Beyond the last.
  EXPECT_EQ(ValidUtf8("\xe2\x82"), "??");
}

}  // namespace
}  // namespace isthmus
