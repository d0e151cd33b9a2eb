#include "api/convert/retry_after.h"

#include <absl/strings/cord.h>
#include <absl/strings/string_view.h>
#include <google/protobuf/any.pb.h>
#include <google/protobuf/duration.pb.h>
#include <google/protobuf/unknown_field_set.h>

#include <utility>

namespace isthmus::convert {
namespace {

// The messages of google/rpc are in no package of Debian's: written and read by field number, see
// https://github.com/googleapis/googleapis/blob/master/google/rpc/status.proto and
// error_details.proto.
constexpr char kRetryInfo[] = "type.googleapis.com/google.rpc.RetryInfo";

}  // namespace

absl::Status WithRetryAfter(absl::Status status, std::chrono::milliseconds after) {
  google::protobuf::Duration delay;
  delay.set_seconds(after.count() / 1000);
  delay.set_nanos(static_cast<int32_t>(after.count() % 1000 * 1'000'000));
  google::protobuf::UnknownFieldSet info;
  info.AddLengthDelimited(1, delay.SerializeAsString());
  std::string bytes;
  (void)info.SerializeToString(&bytes);
  status.SetPayload(kRetryInfo, absl::Cord(bytes));
  return status;
}

std::optional<std::chrono::milliseconds> RetryAfter(const absl::Status& status) {
  const absl::optional<absl::Cord> payload = status.GetPayload(kRetryInfo);
  google::protobuf::UnknownFieldSet info;
  if (!payload || !info.ParseFromString(std::string(*payload)) || info.field_count() != 1 ||
      info.field(0).type() != google::protobuf::UnknownField::TYPE_LENGTH_DELIMITED) {
    return std::nullopt;
  }
  google::protobuf::Duration delay;
  if (!delay.ParseFromString(info.field(0).length_delimited())) return std::nullopt;
  return std::chrono::milliseconds(delay.seconds() * 1000 + delay.nanos() / 1'000'000);
}

std::string StatusDetails(const absl::Status& status, const std::string& message) {
  google::protobuf::UnknownFieldSet details;
  status.ForEachPayload([&](absl::string_view url, const absl::Cord& payload) {
    google::protobuf::Any any;
    any.set_type_url(std::string(url));
    any.set_value(std::string(payload));
    if (details.empty()) {
      details.AddVarint(1, static_cast<uint64_t>(status.raw_code()));
      details.AddLengthDelimited(2, message);
    }
    details.AddLengthDelimited(3, any.SerializeAsString());
  });
  std::string bytes;
  if (!details.empty()) (void)details.SerializeToString(&bytes);
  return bytes;
}

absl::Status WithDetails(absl::Status status, const std::string& details) {
  google::protobuf::UnknownFieldSet fields;
  if (!fields.ParseFromString(details)) return status;
  for (int i = 0; i < fields.field_count(); ++i) {
    const google::protobuf::UnknownField& field = fields.field(i);
    google::protobuf::Any any;
    if (field.number() == 3 &&
        field.type() == google::protobuf::UnknownField::TYPE_LENGTH_DELIMITED &&
        any.ParseFromString(field.length_delimited())) {
      status.SetPayload(any.type_url(), absl::Cord(any.value()));
    }
  }
  return status;
}

}  // namespace isthmus::convert
