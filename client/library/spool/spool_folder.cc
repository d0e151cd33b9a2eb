#include "client/library/spool/spool_folder.h"

#include <absl/strings/str_format.h>

#include <filesystem>
#include <system_error>

#include "core/io/folder.h"

namespace isthmus::client {
namespace {

std::string PathIn(const std::string& folder, uint64_t number) {
  return absl::StrFormat("%s/%06d", folder, number);
}

}  // namespace

absl::StatusOr<std::unique_ptr<SpoolFolder>> SpoolFolder::Open(const std::string& path) {
  auto lock = io::DirectoryLock::Acquire(path, {"lock", "the spool"});
  if (!lock.ok()) return lock.status();
  return std::unique_ptr<SpoolFolder>(new SpoolFolder(path, *std::move(lock)));
}

absl::StatusOr<std::vector<std::unique_ptr<DiskSpool>>> SpoolFolder::Load(
    const DiskSpool::Options& options) {
  const absl::StatusOr<std::vector<uint64_t>> numbers = io::ListNumbers(path_, "");
  if (!numbers.ok()) return numbers.status();
  std::vector<std::unique_ptr<DiskSpool>> spools;
  for (const uint64_t number : *numbers) {
    newest_ = number;
    const std::string path = PathIn(path_, number);
    std::error_code error;
    if (IsOfNoUse(path)) {
      std::filesystem::remove_all(path, error);
      continue;
    }
    auto spool = DiskSpool::Open(path, options);
    if (!spool.ok()) return spool.status();
    spools.push_back(*std::move(spool));
  }
  return spools;
}

absl::StatusOr<std::unique_ptr<DiskSpool>> SpoolFolder::Add(const SpoolIdentity& identity,
                                                            const DiskSpool::Options& options) {
  return DiskSpool::Create(PathIn(path_, ++newest_), identity, options);
}

}  // namespace isthmus::client
