// Damaged files of a robot's spool: the one that says whose scans they are, and one of scans. The
// first byte chooses.
#include <stdlib.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "client/library/spool/disk_spool.h"
#include "client/library/spool/spool_identity.h"
#include "core/io/file_io.h"

namespace isthmus::client {
namespace {

// In memory where there is such a file system; removed at the end.
class Folder {
 public:
  Folder() {
    char name[] = "/dev/shm/fuzz_spool_XXXXXX";
    if (mkdtemp(name) == nullptr) std::abort();
    path_ = name;
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

void TryIdentity(const std::string& folder, const std::string& bytes) {
  if (!io::WriteFile(folder + "/session", bytes).ok()) std::abort();
  (void)ReadIdentity(folder);
}

// All scans that are said to be there can be read, or are said to be damaged.
void TryScans(const std::string& folder, const std::string& name, const std::string& bytes) {
  SpoolIdentity identity;
  identity.request.set_request_id("fuzz");
  if (!WriteIdentity(folder, identity).ok()) std::abort();
  if (!io::WriteFile(folder + "/" + name, bytes).ok()) std::abort();
  const auto spool = DiskSpool::Open(folder, {});
  if (!spool.ok()) return;
  size_t found = 0;
  for (uint64_t i = (*spool)->first(); i <= (*spool)->written() && ++found < 100; ++i) {
    if ((*spool)->Find(i)) (void)(*spool)->Read(i);
  }
  (void)(*spool)->Append(1, "scan", 0);
}

}  // namespace
}  // namespace isthmus::client

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace isthmus::client;
  if (size == 0) return 0;
  const Folder folder;
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] == 'i') {
    TryIdentity(folder.path(), bytes);
  } else {
    TryScans(folder.path(), "00000000000000000001.scans", bytes);
  }
  return 0;
}
