#include "client/library/spool_identity.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <bit>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>

#include "client/library/part_file.h"
#include "client/library/spool_segment.h"
#include "core/io/crc32c.h"

namespace isthmus::client {
namespace {

// Then three strings, each behind its length (u32): the request, the session's id, and base and
// `closed` as nine bytes; then the crc32c of all before. Little endian.
constexpr char kIdentityMagic[] = "ISTHSPI1";
constexpr size_t kIdentityMagicBytes = 8;

void PutString(std::string& out, const std::string& value) {
  const auto size = static_cast<uint32_t>(value.size());
  out.append(reinterpret_cast<const char*>(&size), sizeof(size));
  out += value;
}

// False when there are not as many bytes.
bool TakeString(const std::string& bytes, size_t& at, std::string& value) {
  uint32_t size = 0;
  if (bytes.size() - at < sizeof(size)) return false;
  std::memcpy(&size, bytes.data() + at, sizeof(size));
  at += sizeof(size);
  if (bytes.size() - at < size) return false;
  value = bytes.substr(at, size);
  at += size;
  return true;
}

}  // namespace

absl::Status WriteIdentity(const std::string& folder, const SpoolIdentity& identity) {
  std::string bytes(kIdentityMagic, kIdentityMagicBytes);
  PutString(bytes, identity.request.SerializeAsString());
  PutString(bytes, identity.session);
  std::string numbers(reinterpret_cast<const char*>(&identity.base), sizeof(identity.base));
  numbers += identity.closed ? '\1' : '\0';
  PutString(bytes, numbers);
  const uint32_t crc = io::Crc32c(bytes.data(), bytes.size());
  bytes.append(reinterpret_cast<const char*>(&crc), sizeof(crc));

  PartFile file(folder + "/session");
  absl::Status status = file.Open();
  if (status.ok()) status = file.Append(bytes);
  if (status.ok()) status = file.Commit();
  if (status.ok()) status = SyncFolder(folder);
  return status;
}

absl::StatusOr<SpoolIdentity> ReadIdentity(const std::string& folder) {
  const std::string path = folder + "/session";
  std::ifstream file(path, std::ios::binary);
  if (!file) return absl::NotFoundError(absl::StrCat("there is no ", path));
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const absl::Status damaged = absl::DataLossError(absl::StrCat(path, " is damaged"));
  uint32_t crc = 0;
  if (bytes.size() < kIdentityMagicBytes + sizeof(crc)) return damaged;
  std::memcpy(&crc, &bytes[bytes.size() - sizeof(crc)], sizeof(crc));
  bytes.resize(bytes.size() - sizeof(crc));
  if (io::Crc32c(bytes.data(), bytes.size()) != crc) return damaged;
  if (bytes.compare(0, kIdentityMagicBytes, kIdentityMagic) != 0) return damaged;
  SpoolIdentity identity;
  std::string request, numbers;
  size_t at = kIdentityMagicBytes;
  if (!TakeString(bytes, at, request) || !TakeString(bytes, at, identity.session) ||
      !TakeString(bytes, at, numbers) || numbers.size() != sizeof(identity.base) + 1 ||
      !identity.request.ParseFromString(request)) {
    return damaged;
  }
  std::memcpy(&identity.base, numbers.data(), sizeof(identity.base));
  identity.closed = numbers.back() != '\0';
  return identity;
}

std::string NewRequestId() {
  std::random_device random;
  std::string id;
  for (int i = 0; i < 4; ++i) absl::StrAppendFormat(&id, "%08x", random());
  return id;
}

}  // namespace isthmus::client
