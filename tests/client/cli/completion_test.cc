// Completions that bash offers when a person presses Tab.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "tests/client/cli/program.h"

namespace isthmus::cli {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::IsSupersetOf;
using testing::Not;
using testing::StartsWith;
using testing::UnorderedElementsAre;

// The words offered for the last one of the command line, which may be empty: ''.
std::vector<std::string> Complete(const std::string& line) {
  const ProgramResult result = RunProgram(
      "bash", "-c \"source " COMPLETION_FILE "; COMP_WORDS=(" ISTHMUS_PROGRAM " " + line +
                  "); COMP_CWORD=\\$((\\${#COMP_WORDS[@]} - 1)); _isthmus; "
                  "printf '%s\\n' \\\"\\${COMPREPLY[@]}\\\"\"");
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(result.err, "");
  std::vector<std::string> words;
  std::istringstream lines(result.out);
  for (std::string word; std::getline(lines, word);) {
    if (!word.empty()) words.push_back(word);
  }
  return words;
}

TEST(Completion, CommandsOfBothPrograms) {
  EXPECT_THAT(Complete("''"), IsSupersetOf({"push", "anchor", "merge", "bench"}));
  EXPECT_THAT(Complete("re"), UnorderedElementsAre("revisions", "rebuild", "report"));
}

TEST(Completion, OptionsOfACommandOfEither) {
  EXPECT_THAT(Complete("push --s"),
              UnorderedElementsAre("--server", "--site", "--sensor", "--spool", "--stamps"));
  EXPECT_THAT(Complete("merge --"), AllOf(Contains("--unverified"), Each(StartsWith("--"))));
}

TEST(Completion, CommandsBelowCommandsAndTheirOptions) {
  EXPECT_THAT(Complete("anchor ''"), UnorderedElementsAre("set", "remove", "list", "import"));
  EXPECT_THAT(Complete("anchor set --sigma"),
              UnorderedElementsAre("--sigma-xy", "--sigma-z", "--sigma-deg"));
}

TEST(Completion, ValuesWhereTheHelpNamesThemAndFilesWhereAnOptionTakesAny) {
  EXPECT_THAT(Complete("graph --format ''"),
              UnorderedElementsAre("text", "json", "dot", "nav2", "vda5050"));
  EXPECT_THAT(Complete("graph --format d"), ElementsAre("dot"));
  EXPECT_THAT(Complete("revisions --server u"), IsEmpty());
  EXPECT_THAT(Complete("push --robot merge --un"), Not(Contains("--unverified")));
}

}  // namespace
}  // namespace isthmus::cli
