#include "core/state_codec.h"

#include <absl/strings/str_cat.h>

namespace isthmus {
namespace {

constexpr size_t kMagicSize = 4;  // Format.
constexpr size_t kHeaderSize =    // Format.
    kMagicSize + sizeof(uint32_t) + 2 * sizeof(uint64_t);

uint64_t Mixed(uint64_t hash) {
  hash = (hash ^ hash >> 30) * 0xbf58476d1ce4e5b9ULL;
  hash = (hash ^ hash >> 27) * 0x94d049bb133111ebULL;
  return hash ^ hash >> 31;
}

}  // namespace

uint64_t StateChecksum(const char* data, size_t size) {
  constexpr uint64_t kPrime = 0x100000001b3ULL;
  uint64_t hash = 0xcbf29ce484222325ULL ^ size;
  for (; size >= sizeof(uint64_t); data += sizeof(uint64_t), size -= sizeof(uint64_t)) {
    uint64_t word;
    std::memcpy(&word, data, sizeof(word));
    hash = std::rotl((hash ^ word) * kPrime, 29);
  }
  uint64_t rest = 0;
  std::memcpy(&rest, data, size);
  return Mixed(hash ^ rest * kPrime);
}

std::string SealState(const char* magic, uint32_t version, uint64_t options, std::string state) {
  StateWriter header;
  header.Raw(magic, kMagicSize);
  header(version, options, StateChecksum(state.data(), state.size()));
  return state.insert(0, header.Take());
}

absl::StatusOr<StateReader> OpenState(const char* magic, uint32_t version, uint64_t options,
                                      const std::string& sealed, const std::string& name) {
  if (sealed.size() < kHeaderSize || sealed.compare(0, kMagicSize, magic, kMagicSize) != 0) {
    return absl::DataLossError(absl::StrCat("this is no state of ", name));
  }
  StateReader header(sealed.data() + kMagicSize, kHeaderSize - kMagicSize);
  uint32_t its_version = 0;
  uint64_t its_options = 0, checksum = 0;
  header(its_version, its_options, checksum);
  if (its_version != version) {
    return absl::InvalidArgumentError(absl::StrCat("the state of ", name, " is of version ",
                                                   its_version, "; this program reads version ",
                                                   version));
  }
  const char* const state = sealed.data() + kHeaderSize;
  const size_t size = sealed.size() - kHeaderSize;
  if (checksum != StateChecksum(state, size)) {
    return absl::DataLossError(
        absl::StrCat("the state of ", name, " is damaged: its checksum is wrong"));
  }
  if (its_options != options) {
    return absl::InvalidArgumentError(
        absl::StrCat("the state of ", name, " was made with another sensor or other settings"));
  }
  return StateReader(state, size);
}

}  // namespace isthmus
