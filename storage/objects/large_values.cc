#include "storage/objects/large_values.h"

#include <absl/strings/escaping.h>
#include <absl/strings/match.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/time/clock.h>

#include <algorithm>
#include <utility>

#include "core/io/crc32c.h"
#include "core/io/secret.h"
#include "core/io/sha256.h"

namespace isthmus::storage {
namespace {

// Followed by name, bytes and checksum, parted by spaces. No value begins so by chance; one that
// does all the same goes into the bucket, however small.
constexpr char kReference[] = "isthmus object 1 ";
constexpr size_t kNameBytes = 16;  // Format.
constexpr char kAbout[] = "about.txt";

bool IsName(const std::string& text) {
  return text.size() == 2 * kNameBytes && std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

absl::Status NotThere(const ObjectReference& object, const std::string& why) {
  return absl::DataLossError(absl::StrCat("its object ", object.name, " in the bucket ", why));
}

}  // namespace

std::optional<ObjectReference> FindReference(const std::string& in_row) {
  if (in_row.size() > kLongestReference || !absl::StartsWith(in_row, kReference)) {
    return std::nullopt;
  }
  const std::vector<std::string> words = absl::StrSplit(in_row.substr(sizeof(kReference) - 1), ' ');
  ObjectReference object;
  if (words.size() != 3 || !IsName(words[0]) || !absl::SimpleAtoi(words[1], &object.bytes) ||
      !absl::SimpleAtoi(words[2], &object.crc32c)) {
    return std::nullopt;
  }
  object.name = words[0];
  return object;
}

uint64_t BytesOfValue(const std::string& in_row) {
  const std::optional<ObjectReference> object = FindReference(in_row);
  return object ? object->bytes : in_row.size();
}

absl::StatusOr<std::string> LargeValues::Put(std::string value) {
  if (value.size() < smallest_ && !absl::StartsWith(value, kReference)) return value;
  const std::string hash = io::Sha256(value.data(), value.size());
  {
    MutexLock lock(&mutex_);
    const Known* known = known_.Use(hash);
    if (known != nullptr && absl::Now() - known->put < kSameObject) return known->in_row;
  }
  const absl::StatusOr<std::string> random = io::RandomBytes(kNameBytes);
  if (!random.ok()) return random.status();
  const std::string name = absl::BytesToHexString(*random);
  if (const absl::Status status = bucket_->Put(folder_ + name, value); !status.ok()) {
    return absl::UnavailableError(status.message());
  }
  std::string in_row = absl::StrCat(kReference, name, " ", value.size(), " ",
                                    io::Crc32c(value.data(), value.size()));
  MutexLock lock(&mutex_);
  known_.Put(hash, {in_row, absl::Now()});
  while (known_.size() > kKnownObjects) known_.DropOldest();
  return in_row;
}

absl::StatusOr<std::string> LargeValues::Get(std::string in_row) {
  const std::optional<ObjectReference> object = FindReference(in_row);
  if (!object) return in_row;
  for (int reading = 0; reading < kReadings; ++reading) {
    absl::StatusOr<std::string> value = bucket_->Get(folder_ + object->name);
    if (absl::IsNotFound(value.status())) return NotThere(*object, "is gone");
    if (!value.ok()) return absl::UnavailableError(value.status().message());
    const bool is_whole = value->size() == object->bytes &&
                          io::Crc32c(value->data(), value->size()) == object->crc32c;
    if (is_whole) return value;
  }
  return NotThere(*object, "is damaged: its checksum is wrong");
}

absl::Status LargeValues::Check() { return bucket_->Get(folder_ + kAbout).status(); }

absl::Status LargeValues::Describe(const std::string& text) {
  return bucket_->Put(folder_ + kAbout, text);
}

absl::StatusOr<std::vector<std::string>> LargeValues::List() {
  const auto listed = bucket_->List(folder_);
  if (!listed.ok()) return listed.status();
  std::vector<std::string> names;
  for (const std::string& object : *listed) {
    std::string name = object.substr(folder_.size());
    if (IsName(name)) names.push_back(std::move(name));
  }
  return names;
}

}  // namespace isthmus::storage
