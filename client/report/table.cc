#include "client/report/table.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/strings/str_replace.h>

#include <algorithm>

#include "client/report/limits.h"

namespace isthmus::report {
namespace {

// Line breaks and other control characters would end a row, or do worse on a terminal.
std::string OneLine(absl::string_view text) {
  std::string out(text);
  for (char& c : out) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return out;
}

std::string EscapeMarkdown(absl::string_view text) {
  return absl::StrReplaceAll(
      OneLine(text), {{"\\", "\\\\"}, {"|", "\\|"}, {"*", "\\*"}, {"`", "\\`"}, {"<", "&lt;"}});
}

std::string EscapeLatex(absl::string_view text) {
  return absl::StrReplaceAll(OneLine(text), {{"\\", "\\textbackslash{}"},
                                             {"{", "\\{"},
                                             {"}", "\\}"},
                                             {"$", "\\$"},
                                             {"&", "\\&"},
                                             {"#", "\\#"},
                                             {"%", "\\%"},
                                             {"_", "\\_"},
                                             {"~", "\\textasciitilde{}"},
                                             {"^", "\\textasciicircum{}"},
                                             {"<", "\\textless{}"},
                                             {">", "\\textgreater{}"}});
}

// Columns that a terminal needs for it: the bytes of UTF-8 that begin a character.
size_t WidthOf(absl::string_view text) {
  return static_cast<size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string TextTable(const Table& table) {
  std::vector<size_t> widths;
  for (const std::string& column : table.columns) widths.push_back(WidthOf(column));
  for (const auto& row : table.rows) {
    for (size_t i = 0; i < row.size() && i < widths.size(); ++i) {
      widths[i] = std::max(widths[i], WidthOf(OneLine(row[i])));
    }
  }
  const auto line = [&](const std::vector<std::string>& cells) {
    std::string out;
    for (size_t i = 0; i < cells.size() && i < widths.size(); ++i) {
      const std::string cell = OneLine(cells[i]);
      const std::string gap(widths[i] - WidthOf(cell), ' ');
      absl::StrAppend(&out, i > 0 ? "  " : "", i < table.names ? cell + gap : gap + cell);
    }
    out.erase(out.find_last_not_of(' ') + 1);
    return out + "\n";
  };
  std::string out = absl::StrCat(table.title, "\n", line(table.columns));
  for (const auto& row : table.rows) out += line(row);
  if (!table.note.empty()) absl::StrAppend(&out, table.note, "\n");
  return out;
}

std::string MarkdownTable(const Table& table) {
  const auto line = [](const std::vector<std::string>& cells) {
    return absl::StrCat("| ",
                        absl::StrJoin(cells, " | ",
                                      [](std::string* out, const std::string& cell) {
                                        out->append(EscapeMarkdown(cell));
                                      }),
                        " |\n");
  };
  std::string out =
      absl::StrCat("**", EscapeMarkdown(table.title), "**\n\n", line(table.columns), "|");
  for (size_t i = 0; i < table.columns.size(); ++i) out += i < table.names ? "---|" : "---:|";
  out += "\n";
  for (const auto& row : table.rows) out += line(row);
  if (!table.note.empty()) absl::StrAppend(&out, "\n", EscapeMarkdown(table.note), "\n");
  return out;
}

std::string LatexTable(const Table& table) {
  const auto line = [](const std::vector<std::string>& cells) {
    return absl::StrCat("  ",
                        absl::StrJoin(cells, " & ",
                                      [](std::string* out, const std::string& cell) {
                                        out->append(EscapeLatex(cell));
                                      }),
                        " \\\\\n");
  };
  std::string out = absl::StrCat("\\begin{table}\n  \\centering\n  \\caption{",
                                 EscapeLatex(table.title), "}\n  \\begin{tabular}{");
  for (size_t i = 0; i < table.columns.size(); ++i) out += i < table.names ? "l" : "r";
  absl::StrAppend(&out, "}\n  \\toprule\n", line(table.columns), "  \\midrule\n");
  for (const auto& row : table.rows) out += line(row);
  absl::StrAppend(&out, "  \\bottomrule\n  \\end{tabular}\n");
  if (!table.note.empty()) {
    absl::StrAppend(&out, "  \\par\\smallskip\\footnotesize ", EscapeLatex(table.note), "\n");
  }
  return out + "\\end{table}\n";
}

std::string HtmlTable(const Table& table) {
  const auto line = [&](const std::vector<std::string>& cells, const char* tag) {
    std::string out = "<tr>";
    for (size_t i = 0; i < cells.size(); ++i) {
      const bool is_long = cells[i].size() > kLongCell;
      const char* kind = i >= table.names ? " class=\"n\"" : is_long ? " class=\"long\"" : "";
      absl::StrAppend(&out, "<", tag, kind, ">", EscapeHtml(cells[i]), "</", tag, ">");
    }
    return out + "</tr>\n";
  };
  std::string out = "<div class=\"wide\"><table>\n";
  if (!table.title.empty()) {
    absl::StrAppend(&out, "<caption>", EscapeHtml(table.title), "</caption>\n");
  }
  absl::StrAppend(&out, "<thead>", line(table.columns, "th"), "</thead>\n<tbody>\n");
  for (const auto& row : table.rows) out += line(row, "td");
  out += "</tbody></table></div>\n";
  if (!table.note.empty()) out += FormatParagraph(table.note, TableFormat::kHtml);
  return out;
}

}  // namespace

TableFormat ParseTableFormat(absl::string_view name) {
  if (name == "markdown") return TableFormat::kMarkdown;
  if (name == "latex") return TableFormat::kLatex;
  return name == "html" ? TableFormat::kHtml : TableFormat::kText;
}

std::string Format(const Table& table, TableFormat format) {
  switch (format) {
    case TableFormat::kMarkdown:
      return MarkdownTable(table);
    case TableFormat::kLatex:
      return LatexTable(table);
    case TableFormat::kHtml:
      return HtmlTable(table);
    case TableFormat::kText:
      break;
  }
  return TextTable(table);
}

std::string FormatParagraph(const std::string& text, TableFormat format) {
  switch (format) {
    case TableFormat::kMarkdown:
      return EscapeMarkdown(text) + "\n";
    case TableFormat::kLatex:
      return EscapeLatex(text) + "\n";
    case TableFormat::kHtml:
      return absl::StrCat("<p>", EscapeHtml(text), "</p>\n");
    case TableFormat::kText:
      break;
  }
  return OneLine(text) + "\n";
}

std::string EscapeHtml(absl::string_view text) {
  return absl::StrReplaceAll(
      text, {{"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}, {"'", "&#39;"}});
}

}  // namespace isthmus::report
