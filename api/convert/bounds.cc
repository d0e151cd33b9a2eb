#include "api/convert/bounds.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/io/sha256.h"
#include "core/plain_text.h"
#include "isthmus/v1/types.pb.h"

namespace isthmus::convert {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

// Names of robots, sites, tokens, sensors and fields of clouds, as server/access and the API have
// them, and what clients choose to know a request again.
constexpr size_t kName = 64;
// A robot's name, a number, and that of a segment. It may stand where a robot's name may.
constexpr size_t kSession = 96;
constexpr size_t kNote = 1000;
// Values in one list, as of one token's robots or of kinds of events: nobody types as many.
constexpr size_t kValues = 100;
constexpr size_t kSessions = 1000;  // Sessions of one query.
constexpr size_t kCorners = 1000;
constexpr size_t kCloudFields = 256;
// The points name theirs by 16 bits.
constexpr size_t kKeyframes = 65'535;

struct Row {
  absl::string_view field;
  FieldBound bound;
};

// Others than of a name and of a list of names.
constexpr Row kBounds[] = {
    {"corners", {kCorners, 0}},
    {"data", {0, kAsTheMessage}},
    {"fields", {kCloudFields, 0}},
    {"keyframes", {kKeyframes, 0}},
    {"map", {0, kSession}},
    {"note", {0, kNote}},
    {"path", {kCorners, 0}},
    {"robot", {0, kSession}},
    {"session", {0, kSession}},
    {"session_a", {0, kSession}},
    {"session_b", {0, kSession}},
    {"sessions", {kSessions, kSession}},
    {"sha256", {0, io::kSha256Bytes}},
};

absl::Status TooMuch(const FieldDescriptor& field, size_t has, const char* what, size_t most) {
  return absl::InvalidArgumentError(absl::StrCat(field.containing_type()->name(), ".", field.name(),
                                                 " has ", has, " ", what, ": give at most ", most));
}

absl::Status CheckText(const FieldDescriptor& field, const std::string& text, size_t most) {
  const bool bytes = field.type() == FieldDescriptor::TYPE_BYTES;
  if (text.size() <= most) {
    if (bytes || WithoutSecrets(text).size() == text.size()) return absl::OkStatus();
    return absl::InvalidArgumentError(
        absl::StrCat(field.containing_type()->name(), ".", field.name(),
                     " holds the secret of a token, which others would read: leave it out"));
  }
  return TooMuch(field, text.size(), bytes ? "bytes" : "characters", most);
}

absl::Status CheckValues(const Message& message, const FieldDescriptor& field) {
  const Reflection& in = *message.GetReflection();
  const FieldBound bound = BoundOf(field);
  const auto values = static_cast<size_t>(in.FieldSize(message, &field));
  if (values > bound.values) return TooMuch(field, values, "values", bound.values);
  std::string scratch;
  for (int i = 0; i < static_cast<int>(values); ++i) {
    absl::Status status;
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      status = CheckBounds(in.GetRepeatedMessage(message, &field, i));
    } else if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING) {
      const auto& text = in.GetRepeatedStringReference(message, &field, i, &scratch);
      status = CheckText(field, text, bound.length);
    }
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status CheckField(const Message& message, const FieldDescriptor& field) {
  const Reflection& in = *message.GetReflection();
  if (field.is_repeated()) return CheckValues(message, field);
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
    if (field.message_type() == v1::PointCloud::descriptor()) return absl::OkStatus();
    return CheckBounds(in.GetMessage(message, &field));
  }
  if (field.cpp_type() != FieldDescriptor::CPPTYPE_STRING) return absl::OkStatus();
  std::string scratch;
  return CheckText(field, in.GetStringReference(message, &field, &scratch), BoundOf(field).length);
}

}  // namespace

FieldBound BoundOf(const FieldDescriptor& field) {
  const auto* const found = std::find_if(std::begin(kBounds), std::end(kBounds),
                                         [&](const Row& row) { return row.field == field.name(); });
  if (found != std::end(kBounds)) return found->bound;
  return {field.is_repeated() ? kValues : 0,
          field.cpp_type() == FieldDescriptor::CPPTYPE_STRING ? kName : 0};
}

absl::Status CheckBounds(const Message& message) {
  std::vector<const FieldDescriptor*> fields;
  message.GetReflection()->ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    if (absl::Status status = CheckField(message, *field); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace isthmus::convert
