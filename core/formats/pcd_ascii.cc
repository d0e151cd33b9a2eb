#include "core/formats/pcd_ascii.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>

#include <charconv>
#include <optional>

#include "core/codec/column.h"
#include "core/formats/field_names.h"
#include "core/formats/number_text.h"

namespace isthmus::formats {
namespace {

bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

// Reads words and keeps count of the rows.
class RowReader {
 public:
  RowReader(const char* begin, const char* end) : at_(begin), end_(end) {}

  // The next word of the row; false at its end.
  bool NextWord(const char** begin, const char** end) {
    while (at_ < end_ && IsSpace(*at_) && *at_ != '\n') ++at_;
    *begin = at_;
    while (at_ < end_ && !IsSpace(*at_)) ++at_;
    *end = at_;
    return *begin < *end;
  }

  // Skips to the next row that is not empty; false at the end of the data.
  bool NextRow() {
    while (at_ < end_ && IsSpace(*at_)) ++at_;
    return at_ < end_;
  }

 private:
  const char* at_;
  const char* const end_;
};

absl::Status BadRow(uint64_t row, const std::string& why) {
  return absl::InvalidArgumentError(absl::StrCat("PCD data, row ", row + 1, ": ", why));
}

absl::Status ParseRow(RowReader& reader, const PcdHeader& header,
                      const std::vector<std::optional<ScalarType>>& types, uint64_t row,
                      char* record) {
  const char *begin = nullptr, *end = nullptr;
  for (size_t f = 0; f < header.fields.size(); ++f) {
    const PcdField& field = header.fields[f];
    for (uint32_t k = 0; k < field.count; ++k, record += field.size) {
      if (!reader.NextWord(&begin, &end)) return BadRow(row, "too few values");
      const absl::string_view word(begin, static_cast<size_t>(end - begin));
      if (!types[f] || StoreNumber(word, *types[f], record) || !IsAxis(field.name)) continue;
      return BadRow(row, absl::StrCat("'", word.substr(0, 40), "' is not a value of field '",
                                      field.name, "'"));
    }
  }
  if (reader.NextWord(&begin, &end)) return BadRow(row, "too many values");
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::string> ParsePcdRows(const std::string& bytes, const PcdHeader& header) {
  std::vector<std::optional<ScalarType>> types;
  uint64_t values = 0;
  for (const PcdField& field : header.fields) {
    types.push_back(ToScalarType(field));
    values += field.count;
  }
  // A value takes a digit and what parts it from the next. Checked before memory is taken.
  const uint64_t size = bytes.size() - header.data_start;
  if (header.Points() > (size + 1) / 2 / values) {
    return absl::InvalidArgumentError(absl::StrCat("PCD data: ", header.Points(), " points of ",
                                                   values, " values cannot be in ", size,
                                                   " bytes; is the file truncated?"));
  }
  std::string records(header.Points() * header.Stride(), '\0');
  RowReader reader(bytes.data() + header.data_start, bytes.data() + bytes.size());
  for (uint64_t row = 0; row < header.Points(); ++row) {
    if (!reader.NextRow()) {
      return BadRow(row, absl::StrCat("missing; the header announces ", header.Points()));
    }
    const absl::Status status =
        ParseRow(reader, header, types, row, records.data() + row * header.Stride());
    if (!status.ok()) return status;
  }
  return records;
}

void AppendValue(const char* value, ScalarType type, std::string& text) {
  codec::VisitScalar(type, [&](auto zero) {
    char digits[40];
    const auto end =
        std::to_chars(digits, digits + sizeof(digits), codec::LoadAs<decltype(zero)>(value));
    text.append(digits, end.ptr);
  });
}

}  // namespace isthmus::formats
