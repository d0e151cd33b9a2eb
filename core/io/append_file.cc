#include "core/io/append_file.h"

#include <fcntl.h>

#include <algorithm>
#include <utility>

namespace isthmus::io {

absl::StatusOr<std::unique_ptr<AppendFile>> AppendFile::Open(const std::string& path,
                                                             const DiskCalls& disk) {
  return Open(path, O_RDWR | O_CREAT, disk);
}

absl::StatusOr<std::unique_ptr<AppendFile>> AppendFile::OpenToRead(const std::string& path) {
  return Open(path, O_RDONLY, DiskCalls::System());
}

absl::StatusOr<std::unique_ptr<AppendFile>> AppendFile::Open(const std::string& path, int flags,
                                                             const DiskCalls& disk) {
  absl::StatusOr<File> file = File::Open(path, flags, disk);
  if (!file.ok()) return file.status();
  const absl::StatusOr<uint64_t> size = file->Size();
  if (!size.ok()) return size.status();
  return std::unique_ptr<AppendFile>(new AppendFile(*std::move(file), *size));
}

AppendFile::AppendFile(File file, uint64_t size) : file_(std::move(file)), size_(size) {}

absl::Status AppendFile::Append(const std::string& bytes) {
  const absl::Status status = file_.Write(bytes.data(), bytes.size(), size_);
  if (status.ok()) {
    size_ += bytes.size();
  } else {
    is_broken_ = !Truncate(size_).ok();
  }
  return status;
}

absl::Status AppendFile::Truncate(uint64_t size) {
  if (absl::Status status = file_.Truncate(size); !status.ok()) return status;
  size_ = size;
  synced_size_ = std::min(synced_size_, size);
  return absl::OkStatus();
}

absl::Status AppendFile::Sync() {
  const absl::Status status = file_.Sync();
  if (status.ok()) {
    synced_size_ = size_;
  } else {
    is_suspect_ = true;
  }
  return status;
}

absl::StatusOr<std::string> AppendFile::Read(uint64_t offset, size_t size) const {
  std::string bytes(size, '\0');
  const absl::StatusOr<size_t> got = file_.Read(bytes.data(), size, offset);
  if (!got.ok()) return got.status();
  bytes.resize(*got);
  return bytes;
}

}  // namespace isthmus::io
