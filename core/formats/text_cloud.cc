#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/strings/string_view.h>
#include <absl/strings/strip.h>

#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/codec/column.h"
#include "core/formats/cloud_file.h"
#include "core/formats/field_names.h"
#include "core/formats/number_text.h"

namespace isthmus::formats {
namespace {

using Cells = std::vector<absl::string_view>;

absl::Status BadLine(size_t line, const std::string& why) {
  return absl::InvalidArgumentError(absl::StrCat("line ", line, ": ", why));
}

std::optional<double> ParseCell(absl::string_view cell) {
  cell = absl::StripAsciiWhitespace(cell);
  if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"') {
    cell = cell.substr(1, cell.size() - 2);
  }
  return ParseNumber(cell);
}

Cells SplitAtBlanks(absl::string_view row) {
  return absl::StrSplit(row, absl::ByAnyChar(" \t"), absl::SkipEmpty());
}

// A separator may stand behind the last cell, too.
Cells SplitAt(char separator, absl::string_view row) {
  if (separator == ' ') return SplitAtBlanks(row);
  return absl::StrSplit(row, separator);
}

// The separator of a row's values: a semicolon, a comma, a tab with nothing blank between two, else
// blanks.
char SeparatorOf(absl::string_view row) {
  for (const char c : {';', ','}) {
    if (absl::StrContains(row, c)) return c;
  }
  const bool has_tabs = absl::StrContains(absl::StripAsciiWhitespace(row), '\t');
  const bool is_named = !SplitAtBlanks(row).empty() && !ParseCell(SplitAtBlanks(row)[0]);
  return has_tabs && (is_named || SplitAt('\t', row).size() >= SplitAtBlanks(row).size()) ? '\t'
                                                                                          : ' ';
}

void DropEmptyEnd(size_t least, Cells& cells) {
  while (cells.size() > least && absl::StripAsciiWhitespace(cells.back()).empty()) cells.pop_back();
}

// The text behind the mark of a remark; none for a row of numbers or names.
std::optional<absl::string_view> RemarkOf(absl::string_view row) {
  if (absl::ConsumePrefix(&row, "#") || absl::ConsumePrefix(&row, "//")) return row;
  return std::nullopt;
}

struct Names {
  std::vector<ColumnName> columns;
  char separator = ' ';
};

Names NamesOf(absl::string_view row) {
  Names names;
  names.separator = SeparatorOf(row);
  Cells cells = SplitAt(names.separator, row);
  DropEmptyEnd(0, cells);
  for (const absl::string_view cell : cells) names.columns.push_back(UnderstandColumn(cell));
  return names;
}

Names NamelessColumns(size_t count, char separator) {
  Names names{{}, separator};
  const char* known[] = {"x", "y", "z", "intensity"};
  for (size_t i = 0; i < count; ++i) {
    names.columns.push_back({i < 4 ? known[i] : absl::StrCat("column_", i + 1)});
  }
  return names;
}

absl::Status CheckNames(const Names& names) {
  if (names.columns.size() > codec::kMaxFields) {
    return absl::InvalidArgumentError("there are more columns than a point can have fields");
  }
  for (const char* axis : {"x", "y", "z"}) {
    size_t found = 0;
    for (const ColumnName& column : names.columns) found += column.name == axis;
    if (found != 1) {
      return absl::InvalidArgumentError(
          absl::StrCat(found == 0 ? "no column is" : "several columns are", " named ", axis));
    }
  }
  return absl::OkStatus();
}

// A row that names x, y and z, or has no number.
bool IsNames(absl::string_view row) {
  for (const absl::string_view cell : SplitAt(SeparatorOf(row), row)) {
    if (ParseCell(cell)) return CheckNames(NamesOf(row)).ok();
  }
  return true;
}

// Takes row by row.
class TextReader {
 public:
  absl::Status Take(absl::string_view row) {
    const absl::string_view bare = absl::StripAsciiWhitespace(row);
    if (bare.empty()) return absl::OkStatus();
    if (const auto remark = RemarkOf(bare)) {
      // Some write the names into it. It is a remark where rows have another number of values.
      const bool may_name = payload_.width == 0 && !are_sure_;
      if (may_name && CheckNames(NamesOf(*remark)).ok()) names_ = NamesOf(*remark);
      return absl::OkStatus();
    }
    if (IsCount(bare)) return absl::OkStatus();
    if (payload_.width == 0) {
      if (!are_sure_ && IsNames(bare)) return TakeNames(bare);
      if (absl::Status status = BeginRows(row); !status.ok()) return status;
    }
    return TakeValues(row);
  }

  absl::StatusOr<PointPayload> Finish() {
    if (!names_) return absl::InvalidArgumentError("there are no rows of numbers");
    for (size_t i = 0; i < names_->columns.size(); ++i) {
      // A column of words, or one that is empty, is none.
      const bool is_told = payload_.width == 0 || has_numbers_[i];
      const uint32_t offset = std::exchange(payload_.stride, payload_.stride + 8);
      const std::string& name = names_->columns[i].name;
      if (is_told || IsAxis(name)) {
        payload_.fields.push_back({name, offset, ScalarType::kFloat64, 1});
      }
    }
    return std::move(payload_);
  }

 private:
  // The number of points stands alone in front of them, in a file of several scans of each one's.
  bool IsCount(absl::string_view row) {
    uint64_t count = 0;
    if (!absl::SimpleAtoi(row, &count) || (payload_.width > 0 && payload_.width != announced_)) {
      return false;
    }
    announced_ = payload_.width + count;
    return true;
  }

  absl::Status TakeNames(absl::string_view row) {
    names_ = NamesOf(row);
    are_sure_ = true;
    return CheckNames(*names_);
  }

  // Sees what parts the values by the first row, and whether they are those of a remark's names.
  absl::Status BeginRows(absl::string_view row) {
    const char separator = SeparatorOf(row);
    Cells cells = SplitAt(separator, row);
    DropEmptyEnd(names_ ? names_->columns.size() : 0, cells);
    const bool has_names = names_ && names_->columns.size() == cells.size();
    if (has_names) names_->separator = separator;
    if (has_names || are_sure_) return absl::OkStatus();
    DropEmptyEnd(0, cells);
    if (cells.size() < 3) return absl::InvalidArgumentError("fewer than three numbers in a row");
    names_ = NamelessColumns(cells.size(), separator);
    return CheckNames(*names_);
  }

  absl::Status TakeValues(absl::string_view row) {
    const std::vector<ColumnName>& columns = names_->columns;
    Cells cells = SplitAt(names_->separator, row);
    DropEmptyEnd(columns.size(), cells);
    if (cells.size() != columns.size()) {
      return absl::InvalidArgumentError(
          absl::StrCat(cells.size(), " values, not ", columns.size()));
    }
    has_numbers_.resize(columns.size());
    for (size_t i = 0; i < cells.size(); ++i) {
      const std::optional<double> value = ParseCell(cells[i]);
      if (value) has_numbers_[i] = true;
      if (!value && IsAxis(columns[i].name) && !absl::StripAsciiWhitespace(cells[i]).empty()) {
        return absl::InvalidArgumentError(
            absl::StrCat("'", cells[i].substr(0, 40), "' is no number"));
      }
      const double scaled =
          value.value_or(std::numeric_limits<double>::quiet_NaN()) * columns[i].scale;
      payload_.data.append(reinterpret_cast<const char*>(&scaled), sizeof(scaled));
    }
    if (payload_.width == std::numeric_limits<uint32_t>::max()) {
      return absl::InvalidArgumentError("too many rows");
    }
    ++payload_.width;
    return absl::OkStatus();
  }

  PointPayload payload_;
  std::optional<Names> names_;
  bool are_sure_ = false;  // The names stand in a line of their own.
  std::vector<bool> has_numbers_;
  uint64_t announced_ = 0;
};

}  // namespace

absl::StatusOr<PointPayload> ParseText(const std::string& bytes) {
  TextReader reader;
  size_t line = 0;
  const absl::string_view text = absl::StripPrefix(bytes, "\xEF\xBB\xBF");  // Byte-order mark.
  for (absl::string_view row : absl::StrSplit(text, '\n')) {
    ++line;
    absl::ConsumeSuffix(&row, "\r");
    if (absl::Status status = reader.Take(row); !status.ok()) {
      return BadLine(line, std::string(status.message()));
    }
  }
  return reader.Finish();
}

}  // namespace isthmus::formats
