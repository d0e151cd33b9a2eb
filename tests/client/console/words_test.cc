#include "client/console/words.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace isthmus::cli {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class WordsTest : public testing::Test {
 protected:
  WordsTest() {
    app_.require_subcommand(1);
    app_.add_subcommand("push", "");
    app_.add_subcommand("status", "");
    CLI::App* match = app_.add_subcommand("match", "");
    match->require_subcommand(1);
    match->add_subcommand("reject", "");
    app_.add_subcommand("loops", "")->add_subcommand("restore", "");
  }

  std::vector<std::string> Arrange(const std::vector<std::string>& words) const {
    return Arranged(words, app_);
  }
  std::string Complaint(const std::vector<std::string>& words) const {
    return std::string(CheckCommand(words, app_).message());
  }

  CLI::App app_;
};

TEST_F(WordsTest, TheServerMayStandBeforeTheCommand) {
  EXPECT_THAT(Arrange({"--server", "a:1", "--attempts=2", "push", "x"}),
              ElementsAre("push", "--server", "a:1", "--attempts=2", "x"));
  EXPECT_THAT(Arrange({"--server=a:1", "match", "reject", "a", "b"}),
              ElementsAre("match", "reject", "--server=a:1", "a", "b"));
  EXPECT_THAT(Arrange({"push", "--server", "a:1", "status"}),
              ElementsAre("push", "--server", "a:1", "status"));
  EXPECT_EQ(CommandAt({"--server", "push", "status"}), 2u);
  EXPECT_EQ(CommandAt({"--server"}), 1u) << "the value is missing";
}

TEST_F(WordsTest, HelpIsACommandToo) {
  EXPECT_THAT(Arrange({"help"}), ElementsAre("--help"));
  EXPECT_THAT(Arrange({"help", "match", "reject"}), ElementsAre("match", "reject", "--help"));
  EXPECT_THAT(Arrange({"push", "help"}), ElementsAre("push", "help")) << "a folder of that name";
}

TEST_F(WordsTest, ACommandThatIsNoneIsToldTheNearest) {
  EXPECT_THAT(Complaint({"pusch", "x"}), HasSubstr("did you mean `push`?"));
  EXPECT_THAT(Complaint({"--server", "a:1", "statsu"}), HasSubstr("did you mean `status`?"));
  EXPECT_THAT(Complaint({"help", "psuh"}), HasSubstr("did you mean `push`?"));
  EXPECT_THAT(Complaint({"match", "rejct"}),
              AllOf(HasSubstr("no command `isthmus match rejct`"),
                    HasSubstr("did you mean `reject`?"), HasSubstr("`isthmus help match`")));
  EXPECT_THAT(Complaint({"conquer"}),
              AllOf(Not(HasSubstr("did you mean")), HasSubstr("`isthmus help` lists")));
}

TEST_F(WordsTest, WhatIsNoCommandButAValueIsLeftAlone) {
  EXPECT_EQ(Complaint({"loops", "alice"}), "");
  EXPECT_EQ(Complaint({"match", "--help"}), "");
  EXPECT_EQ(Complaint({"push", "pusch"}), "");
  EXPECT_EQ(Complaint({}), "");
}

}  // namespace
}  // namespace isthmus::cli
