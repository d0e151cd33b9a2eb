// The file that a server's tokens are kept in: read whole, replaced whole.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "server/access/token_text.h"

namespace isthmus::access {

// DIR/tokens, readable by its owner alone. Several processes may change it: one at a time does,
// behind DIR/tokens.lock. Thread safe.
class TokenFile {
 public:
  // The mark of one state of the file: two states are told apart without reading the file.
  struct Version {
    uint64_t inode = 0;  // 0: there is no file.
    int64_t changed_ns = 0;
    int64_t size = 0;
    friend bool operator==(const Version&, const Version&) = default;
  };

  explicit TokenFile(std::string folder) : folder_(std::move(folder)) {}

  std::string path() const { return folder_ + "/tokens"; }
  Version version() const;
  // No file: no tokens. FailedPrecondition, saying what to do, where it is damaged, of a newer
  // version, or cannot be read.
  absl::StatusOr<std::vector<StoredToken>> Read() const;
  // The new tokens are on the disk on return. Errors of Read and of `change`, which then has no
  // effect, and FileError's. Waits while another process changes the file.
  absl::Status Update(const std::function<absl::Status(std::vector<StoredToken>&)>& change) const;

 private:
  absl::Status Replace(const std::string& text) const;

  const std::string folder_;
};

}  // namespace isthmus::access
