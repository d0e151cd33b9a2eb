// A file that only appears under its name once it is complete. Private to the library.
#pragma once

#include <absl/status/status.h>

#include <cstdio>
#include <string>

namespace isthmus::client {

// Writes PATH.part; Commit renames it to PATH. Without Commit it is removed again. Not thread safe.
class PartFile {
 public:
  explicit PartFile(std::string path);
  ~PartFile();
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  // Begins anew with an empty PATH.part. NotFound or PermissionDenied, naming the path.
  absl::Status Open();
  // ResourceExhausted when the disk is full.
  absl::Status Append(const std::string& bytes);
  absl::Status Commit();

 private:
  absl::Status Failure(const char* action) const;  // From errno.
  void Discard();

  const std::string path_, part_;
  std::FILE* file_ = nullptr;
};

}  // namespace isthmus::client
