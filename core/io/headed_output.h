// An output whose head can only be told once its body is written.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/io/file_io.h"
#include "core/io/output_file.h"

namespace isthmus::io {

// As OutputFile. A file is written behind room for its head, which is filled at the end; of a
// stream the body waits in an unnamed file of the folder for temporary files. Errors are
// FileError's. Not thread safe.
class HeadedOutput {
 public:
  HeadedOutput(const std::string& path, uint64_t head_size);
  ~HeadedOutput();
  HeadedOutput(const HeadedOutput&) = delete;
  HeadedOutput& operator=(const HeadedOutput&) = delete;

  absl::Status Open();
  absl::Status Append(const std::string& bytes);
  // Complete. InvalidArgument for a head of another size than promised.
  absl::Status Commit(const std::string& head);

 private:
  absl::Status SendBody();

  const std::string path_;
  const uint64_t head_size_;
  std::optional<OutputFile> stream_;  // If it is one.
  std::string part_;                  // Otherwise; empty once it has its name.
  std::optional<File> body_;
  uint64_t size_ = 0;  // Size of the body.
};

}  // namespace isthmus::io
