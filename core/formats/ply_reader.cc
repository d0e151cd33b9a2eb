#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "core/codec/column.h"
#include "core/formats/cloud_file.h"
#include "core/formats/field_names.h"
#include "core/formats/number_text.h"
#include "core/formats/ply_header.h"

namespace isthmus::formats {
namespace {

// Walks over the data value by value. A value to be kept goes to `out`, as `type.type`.
class AsciiValues {
 public:
  explicit AsciiValues(absl::string_view data) : left_(data) {}

  absl::Status Take(const PlyProperty& property, char* out) {
    const absl::string_view word = NextWord();
    if (word.empty()) return BadPly("fewer rows than the header announces: is it truncated?");
    if (out == nullptr || StoreNumber(word, property.type.type, out) || !IsAxis(property.name)) {
      return absl::OkStatus();
    }
    return BadPly(
        absl::StrCat("'", word.substr(0, 40), "' is no number for '", property.name, "'"));
  }
  std::optional<uint64_t> TakeLength(const PlyType&) {
    const std::optional<double> length = ParseNumber(NextWord());
    // Each value takes a letter at least.
    if (!length || !(*length >= 0 && *length <= static_cast<double>(left_.size()))) return {};
    return static_cast<uint64_t>(*length);
  }
  absl::Status EndRow() {
    while (!left_.empty() && absl::ascii_isspace(left_[0]) && left_[0] != '\n') {
      left_.remove_prefix(1);
    }
    if (left_.empty() || left_[0] == '\n') return absl::OkStatus();
    return BadPly("more values in the row than the header announces");
  }
  // A value takes two bytes at least: a digit, and the blank before the next one.
  bool HasRoomFor(const PlyElement& element) const {
    return element.properties.empty() ||
           element.count <= (left_.size() + 1) / 2 / element.properties.size();
  }

 private:
  absl::string_view NextWord() {
    left_ = absl::StripLeadingAsciiWhitespace(left_);
    const auto end = std::find_if(left_.begin(), left_.end(), absl::ascii_isspace);
    const absl::string_view word = left_.substr(0, static_cast<size_t>(end - left_.begin()));
    left_.remove_prefix(word.size());
    return word;
  }

  absl::string_view left_;
};

class BinaryValues {
 public:
  BinaryValues(absl::string_view data, bool is_big) : left_(data), is_big_(is_big) {}

  absl::Status Take(const PlyProperty& property, char* out) {
    const uint32_t size = property.type.size;
    if (left_.size() < size) return BadPly("the data is cut off");
    if (out != nullptr) Copy(property.type, out);
    left_.remove_prefix(size);
    return absl::OkStatus();
  }
  std::optional<uint64_t> TakeLength(const PlyType& type) {
    if (left_.size() < type.size) return std::nullopt;
    char bytes[8];
    Copy(type, bytes);
    left_.remove_prefix(type.size);
    return codec::VisitScalar(type.type, [&](auto scalar) -> std::optional<uint64_t> {
      const auto length = static_cast<double>(codec::LoadAs<decltype(scalar)>(bytes));
      // Each value takes a byte at least.
      if (!(length >= 0 && length <= static_cast<double>(left_.size()))) return std::nullopt;
      return static_cast<uint64_t>(length);
    });
  }
  absl::Status EndRow() { return absl::OkStatus(); }
  bool HasRoomFor(const PlyElement& element) const {
    const uint64_t least = element.LeastBytes();
    return least == 0 || element.count <= left_.size() / least;
  }

 private:
  void Copy(const PlyType& type, char* out) const {
    std::copy_n(left_.data(), type.size, out);
    if (is_big_) std::reverse(out, out + type.size);
    if (type.is_wide_signed) {
      codec::StoreAs(static_cast<double>(codec::LoadAs<int64_t>(out)), out);
    } else if (type.is_wide_unsigned) {
      codec::StoreAs(static_cast<double>(codec::LoadAs<uint64_t>(out)), out);
    }
  }

  absl::string_view left_;
  const bool is_big_;
};

// Passes over one element; what `record` has a place for is kept, where `record` is given.
template <typename Values>
absl::Status TakeOne(const PlyElement& element, Values& values, char* record) {
  for (const PlyProperty& property : element.properties) {
    uint64_t count = 1;
    if (property.list) {
      const std::optional<uint64_t> length = values.TakeLength(*property.list);
      if (!length) return BadPly(absl::StrCat("the list '", property.name, "' has no length"));
      count = *length;
    }
    char* const out = property.list ? nullptr : record;
    for (uint64_t k = 0; k < count; ++k) {
      if (absl::Status status = values.Take(property, out); !status.ok()) return status;
    }
    if (out != nullptr) record += SizeOf(property.type.type);
  }
  return values.EndRow();
}

template <typename Values>
absl::Status TakeAll(const PlyElement& element, Values& values, uint32_t stride, char* records) {
  if (element.properties.empty()) return absl::OkStatus();
  if (!values.HasRoomFor(element)) {
    return BadPly(absl::StrCat("the header announces ", element.count, " of '", element.name,
                               "', but there is less: is the file truncated?"));
  }
  for (uint64_t i = 0; i < element.count; ++i) {
    char* const record = records == nullptr ? nullptr : records + i * stride;
    if (absl::Status status = TakeOne(element, values, record); !status.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat(status.message(), " (", element.name, " ", i + 1, ")"));
    }
  }
  return absl::OkStatus();
}

// The payload of the points, without their data.
absl::StatusOr<PointPayload> LayoutOf(const PlyElement& vertex) {
  PointPayload payload;
  payload.width = static_cast<uint32_t>(vertex.count);
  for (const PlyProperty& property : vertex.properties) {
    if (property.list) continue;
    if (payload.fields.size() == codec::kMaxFields) return BadPly("too many properties");
    payload.fields.push_back({property.name, payload.stride, property.type.type, 1});
    payload.stride += SizeOf(property.type.type);
  }
  if (payload.fields.empty()) return BadPly("points have no properties");
  return payload;
}

template <typename Values>
absl::StatusOr<PointPayload> ReadPoints(const PlyHeader& header, Values values) {
  absl::StatusOr<PointPayload> payload = LayoutOf(header.vertex());
  if (!payload.ok()) return payload;
  for (size_t i = 0; i + 1 < header.elements.size(); ++i) {
    const absl::Status status = TakeAll(header.elements[i], values, 0, nullptr);
    if (!status.ok()) return status;
  }
  // Before memory is taken.
  if (values.HasRoomFor(header.vertex())) {
    payload->data.resize(uint64_t{payload->width} * payload->stride);
  }
  const absl::Status status =
      TakeAll(header.vertex(), values, payload->stride, payload->data.data());
  if (!status.ok()) return status;
  return payload;
}

}  // namespace

absl::StatusOr<PointPayload> ParsePly(const std::string& bytes) {
  const absl::StatusOr<PlyHeader> header = ParsePlyHeader(bytes);
  if (!header.ok()) return header.status();
  const absl::string_view data = absl::string_view(bytes).substr(header->data_start);
  if (header->encoding == PlyEncoding::kAscii) return ReadPoints(*header, AsciiValues(data));
  return ReadPoints(*header, BinaryValues(data, header->encoding == PlyEncoding::kBig));
}

}  // namespace isthmus::formats
