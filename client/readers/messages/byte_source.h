// Bytes at rest that recordings are read from: a file, or a buffer.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace isthmus::readers {

// Its size is that of when it was opened. Thread safe.
class ByteSource {
 public:
  virtual ~ByteSource() = default;

  virtual uint64_t size() const = 0;
  // Reads exactly so many bytes. DataLoss where the source ends before, errors of io::File.
  virtual absl::Status Read(uint64_t offset, size_t size, char* out) const = 0;
};

// Errors of io::File.
absl::StatusOr<std::shared_ptr<const ByteSource>> OpenFileSource(const std::string& path);

std::shared_ptr<const ByteSource> BufferSource(std::string bytes);

// A part of a source that is kept, for those who go through it in small steps. Not thread safe.
class ByteWindow {
 public:
  explicit ByteWindow(const ByteSource& source, size_t least);

  // `size` bytes at `offset`, valid until the next call. Errors of ByteSource::Read.
  absl::StatusOr<absl::string_view> At(uint64_t offset, size_t size);

 private:
  const ByteSource& source_;
  const size_t least_;  // Bytes that are read at once.
  uint64_t begin_ = 0;
  std::string bytes_;
};

}  // namespace isthmus::readers
