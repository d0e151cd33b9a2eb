// Tables as text, Markdown, LaTeX and HTML.
#pragma once

#include <absl/strings/string_view.h>

#include <cstddef>
#include <string>
#include <vector>

namespace isthmus::report {

enum class TableFormat { kText, kMarkdown, kLatex, kHtml };

// "text", "markdown", "latex" or "html"; kText for any other.
TableFormat ParseTableFormat(absl::string_view name);

// Cells are plain text from anywhere: what has a meaning in a format is escaped.
struct Table {
  std::string title;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;  // Each of as many cells as there are columns.
  size_t names = 1;                            // Columns from the left that hold words.
  std::string note = {};                       // Below the table; empty: none.
};

// Numbers are aligned to the right, words to the left. LaTeX is a table environment that needs the
// package booktabs. Ends with a line break.
std::string Format(const Table& table, TableFormat format);

// Plain text for a place between tables: a paragraph.
std::string FormatParagraph(const std::string& text, TableFormat format);

// Characters with a meaning in HTML, quotes among them, as entities.
std::string EscapeHtml(absl::string_view text);

}  // namespace isthmus::report
