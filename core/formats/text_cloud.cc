#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/strings/string_view.h>

#include <charconv>
#include <limits>
#include <optional>
#include <vector>

#include "core/codec/column.h"
#include "core/formats/cloud_file.h"
#include "core/formats/field_names.h"

namespace isthmus::formats {
namespace {

absl::Status BadLine(size_t line, const std::string& why) {
  return absl::InvalidArgumentError(absl::StrCat("line ", line, ": ", why));
}

// What parts the values: a comma, a semicolon, else blanks.
class RowSplitter {
 public:
  explicit RowSplitter(absl::string_view first_row) {
    for (const char c : {',', ';'}) {
      if (first_row.find(c) != absl::string_view::npos) separator_ = c;
    }
  }
  std::vector<absl::string_view> Split(absl::string_view row) const {
    if (separator_ != ' ') return absl::StrSplit(row, separator_);
    return absl::StrSplit(row, absl::ByAnyChar(" \t"), absl::SkipEmpty());
  }

 private:
  char separator_ = ' ';
};

std::optional<double> ParseCell(absl::string_view cell) {
  cell = absl::StripAsciiWhitespace(cell);
  if (absl::StartsWith(cell, "+")) cell.remove_prefix(1);
  double value = 0;
  const auto parsed = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (parsed.ec != std::errc() || parsed.ptr != cell.data() + cell.size()) return std::nullopt;
  return value;
}

struct Columns {
  std::vector<ColumnName> names;
  bool are_named = false;
};

absl::StatusOr<Columns> ColumnsOf(const std::vector<absl::string_view>& first_row) {
  Columns columns;
  columns.are_named = !ParseCell(first_row[0]).has_value();
  if (first_row.size() > codec::kMaxFields) {
    return absl::InvalidArgumentError("there are more columns than a point can have fields");
  }
  if (!columns.are_named) {
    if (first_row.size() < 3)
      return absl::InvalidArgumentError("fewer than three numbers in a row");
    for (size_t i = 0; i < first_row.size(); ++i) {
      const char* known[] = {"x", "y", "z", "intensity"};
      columns.names.push_back({i < 4 ? known[i] : absl::StrCat("column_", i + 1)});
    }
    return columns;
  }
  for (const absl::string_view cell : first_row) columns.names.push_back(UnderstandColumn(cell));
  for (const char* axis : {"x", "y", "z"}) {
    size_t found = 0;
    for (const ColumnName& column : columns.names) found += column.name == axis;
    if (found != 1) {
      return absl::InvalidArgumentError(absl::StrCat(
          "the first line names ", found == 0 ? "no column " : "several columns ", axis));
    }
  }
  return columns;
}

}  // namespace

absl::StatusOr<PointPayload> ParseText(const std::string& bytes) {
  PointPayload payload;
  std::optional<RowSplitter> splitter;
  std::optional<Columns> columns;
  size_t line = 0;
  for (absl::string_view row : absl::StrSplit(bytes, '\n')) {
    ++line;
    row = absl::StripAsciiWhitespace(row);
    if (row.empty() || absl::StartsWith(row, "#")) continue;
    if (!splitter) splitter.emplace(row);
    const std::vector<absl::string_view> cells = splitter->Split(row);
    if (!columns) {
      absl::StatusOr<Columns> found = ColumnsOf(cells);
      if (!found.ok()) return BadLine(line, std::string(found.status().message()));
      columns = *std::move(found);
      if (columns->are_named) continue;
    }
    if (cells.size() != columns->names.size()) {
      return BadLine(line, absl::StrCat(cells.size(), " values, not ", columns->names.size()));
    }
    for (size_t i = 0; i < cells.size(); ++i) {
      const std::optional<double> value = ParseCell(cells[i]);
      if (!value) return BadLine(line, absl::StrCat("'", cells[i].substr(0, 40), "' is no number"));
      const double scaled = *value * columns->names[i].scale;
      payload.data.append(reinterpret_cast<const char*>(&scaled), sizeof(scaled));
    }
    if (payload.width == std::numeric_limits<uint32_t>::max()) return BadLine(line, "too many");
    ++payload.width;
  }
  if (!columns) return absl::InvalidArgumentError("there are no rows of numbers");
  for (const ColumnName& column : columns->names) {
    payload.fields.push_back({column.name, payload.stride, ScalarType::kFloat64, 1});
    payload.stride += 8;
  }
  return payload;
}

}  // namespace isthmus::formats
