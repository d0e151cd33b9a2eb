// A file that only appears under its name once it is complete.
#pragma once

#include <absl/status/status.h>

#include <memory>
#include <string>

#include "core/io/append_file.h"

namespace isthmus::io {

// Writes PATH.part; Commit renames it to PATH. Without Commit it is removed again. Errors are
// FileError's. Not thread safe.
class PartFile {
 public:
  explicit PartFile(std::string path);
  ~PartFile();
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  // Begins anew with an empty PATH.part.
  absl::Status Open();
  absl::Status Append(const std::string& bytes);
  // The whole file is under its name, and stays there if the power goes.
  absl::Status Commit();

 private:
  const std::string path_, part_;
  std::unique_ptr<AppendFile> file_;  // While PATH.part is there.
};

// The file is there as before or as now, whatever happens.
absl::Status ReplaceFile(const std::string& path, const std::string& bytes);

}  // namespace isthmus::io
