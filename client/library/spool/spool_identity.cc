#include "client/library/spool/spool_identity.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <filesystem>
#include <random>
#include <system_error>

#include "api/convert/session.h"
#include "core/byte_stream.h"
#include "core/io/crc32c.h"
#include "core/io/folder.h"
#include "core/io/part_file.h"
#include "core/odometry_mode.h"

namespace isthmus::client {
namespace {

// Then three strings, each behind its length (u32): the request, the session's id, and base,
// `closed` and created_ns as 17 bytes, of older programs nine, and unsure_from where it is not 0;
// then the crc32c of all before. Little endian.
constexpr char kIdentityMagic[] = "ISTHSPI1";
constexpr size_t kIdentityMagicBytes = 8, kOldNumberBytes = 9, kNumberBytes = 17,
                 kAllNumberBytes = 25;

void PutString(std::string& out, const std::string& value) {
  AppendBytes(static_cast<uint32_t>(value.size()), out);
  out += value;
}

// Spools of older programs name the odometry by a string, under the number that is reserved now.
void TakeOldOdometry(v1::CreateSessionRequest* request) {
  constexpr int kOldOdometry = 4;
  const auto& unknown = request->GetReflection()->GetUnknownFields(*request);
  for (int k = 0; k < unknown.field_count(); ++k) {
    const auto& field = unknown.field(k);
    if (field.number() != kOldOdometry || field.type() != field.TYPE_LENGTH_DELIMITED) continue;
    SessionRequest named;
    named.odometry = FindOdometryMode(field.length_delimited());
    request->set_odometry(convert::ToMessage(named).odometry());
  }
}

std::string PathOf(const std::string& folder) { return folder + "/session"; }
std::string RetiredPathOf(const std::string& folder) { return folder + "/removed"; }

}  // namespace

absl::Status WriteIdentity(const std::string& folder, const SpoolIdentity& identity) {
  std::string bytes(kIdentityMagic, kIdentityMagicBytes);
  PutString(bytes, identity.request.SerializeAsString());
  PutString(bytes, identity.session);
  const bool is_unsure = identity.unsure_from != 0;
  AppendBytes(static_cast<uint32_t>(is_unsure ? kAllNumberBytes : kNumberBytes), bytes);
  AppendBytes(identity.base, bytes);
  bytes += identity.closed ? '\1' : '\0';
  AppendBytes(identity.created_ns, bytes);
  if (is_unsure) AppendBytes(identity.unsure_from, bytes);
  AppendBytes(io::Crc32c(bytes.data(), bytes.size()), bytes);
  return io::ReplaceFile(PathOf(folder), bytes);
}

absl::StatusOr<SpoolIdentity> ReadIdentity(const std::string& folder) {
  const absl::StatusOr<std::string> bytes = io::ReadFile(PathOf(folder));
  if (absl::IsNotFound(bytes.status())) return UnknownOwner(folder, PathOf(folder) + " is missing");
  if (!bytes.ok()) return bytes.status();
  ByteReader reader(*bytes);
  const auto string = [&] { return reader.ReadString(reader.Read<uint32_t>()); };
  SpoolIdentity identity;
  const bool is_ours = reader.ReadString(kIdentityMagicBytes) == kIdentityMagic;
  const bool is_parsed = identity.request.ParseFromString(string());
  TakeOldOdometry(&identity.request);
  identity.session = string();
  const auto number_bytes = reader.Read<uint32_t>();
  identity.base = reader.Read<uint64_t>();
  identity.closed = reader.Read<char>() != '\0';
  if (number_bytes >= kNumberBytes) identity.created_ns = reader.Read<int64_t>();
  if (number_bytes == kAllNumberBytes) identity.unsure_from = reader.Read<uint64_t>();
  const size_t checked = bytes->size() - reader.remaining();
  const bool is_whole = reader.Read<uint32_t>() == io::Crc32c(bytes->data(), checked);
  const bool has_numbers = number_bytes == kNumberBytes || number_bytes == kOldNumberBytes ||
                           number_bytes == kAllNumberBytes;
  if (is_ours && is_parsed && has_numbers && is_whole && reader.ok() && reader.remaining() == 0) {
    return identity;
  }
  return UnknownOwner(folder, PathOf(folder) + " is damaged");
}

absl::Status RetireIdentity(const std::string& folder) {
  std::error_code error;
  std::filesystem::rename(PathOf(folder), RetiredPathOf(folder), error);
  if (!error) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat("cannot remove ", folder, ": ", error.message()));
}

bool IsOfNoUse(const std::string& folder) {
  std::error_code error;
  if (std::filesystem::exists(PathOf(folder), error) || error) return false;
  if (std::filesystem::exists(RetiredPathOf(folder), error)) return true;
  const auto scans = io::ListNumbers(folder, kScansSuffix);
  return scans.ok() && scans->empty();
}

absl::Status UnknownOwner(const std::string& folder, const std::string& why) {
  return absl::DataLossError(absl::StrCat(
      why, ": nothing tells whose scans ", folder,
      " holds. Move that folder away and push the whole drive again, or name another spool"));
}

std::string NewRequestId() {
  std::random_device random;
  std::string id;
  for (int i = 0; i < 4; ++i) absl::StrAppendFormat(&id, "%08x", random());
  return id;
}

}  // namespace isthmus::client
