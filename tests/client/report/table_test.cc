#include "client/report/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace isthmus::report {
namespace {

using testing::HasSubstr;
using testing::Not;

Table Small() {
  return {"Errors", {"", "rmse m"}, {{"alice", "0.5"}, {"bob|<b>&_%", "12.25"}}, 1, "A note."};
}

TEST(Table, TextIsAligned) {
  EXPECT_EQ(Format(Small(), TableFormat::kText),
            "Errors\n"
            "            rmse m\n"
            "alice          0.5\n"
            "bob|<b>&_%   12.25\n"
            "A note.\n");
}

TEST(Table, MarkdownEscapesWhatWouldEndACell) {
  const std::string text = Format(Small(), TableFormat::kMarkdown);
  EXPECT_THAT(text, HasSubstr("|---|---:|\n| alice | 0.5 |\n| bob\\|&lt;b>&_% | 12.25 |\n"));
}

TEST(Table, LatexIsATableWithEverythingEscaped) {
  const std::string text = Format(Small(), TableFormat::kLatex);
  EXPECT_THAT(text, HasSubstr("\\begin{tabular}{lr}"));
  EXPECT_THAT(text, HasSubstr("bob|\\textless{}b\\textgreater{}\\&\\_\\% & 12.25 \\\\"));
  EXPECT_THAT(text, HasSubstr("\\end{table}"));
}

TEST(Table, HtmlEscapesWhatComesFromOutside) {
  Table table = Small();
  table.title = table.note = table.columns[1] = table.rows[0][1] = "<script>\"'&";
  const std::string text = Format(table, TableFormat::kHtml);
  EXPECT_THAT(text, Not(HasSubstr("<script>")));
  EXPECT_THAT(text, HasSubstr("<td class=\"n\">&lt;script&gt;&quot;&#39;&amp;</td>"));
}

TEST(Table, ControlCharactersEndNoRow) {
  const Table table{"t", {"name"}, {{"a\nb\x1b[2J"}}};
  for (const TableFormat format :
       {TableFormat::kText, TableFormat::kMarkdown, TableFormat::kLatex}) {
    EXPECT_THAT(Format(table, format), HasSubstr("a b [2J"));
  }
}

}  // namespace
}  // namespace isthmus::report
