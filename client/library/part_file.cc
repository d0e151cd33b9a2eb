#include "client/library/part_file.h"

#include <absl/strings/str_cat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace isthmus::client {

PartFile::PartFile(std::string path) : path_(std::move(path)), part_(path_ + ".part") {}

PartFile::~PartFile() { Discard(); }

absl::Status PartFile::Open() {
  Discard();
  file_ = std::fopen(part_.c_str(), "wb");
  return file_ != nullptr ? absl::OkStatus() : Failure("open");
}

absl::Status PartFile::Append(const std::string& bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) == bytes.size()) return absl::OkStatus();
  return Failure("write");
}

absl::Status PartFile::Commit() {
  // Only what is on the disk may take the place of an older file.
  const bool written = std::fflush(file_) == 0 && fsync(fileno(file_)) == 0;
  if (!written) return Failure("write");
  std::fclose(file_);
  file_ = nullptr;
  if (std::rename(part_.c_str(), path_.c_str()) == 0) return absl::OkStatus();
  const absl::Status failure = Failure("rename");
  std::remove(part_.c_str());
  return failure;
}

absl::Status PartFile::Failure(const char* action) const {
  const int code = errno;
  return absl::ErrnoToStatus(code, absl::StrCat("cannot ", action, " ", part_));
}

void PartFile::Discard() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  file_ = nullptr;
  std::remove(part_.c_str());
}

}  // namespace isthmus::client
