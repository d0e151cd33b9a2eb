#include "core/io/part_file.h"

#include <cerrno>
#include <cstdio>
#include <utility>

#include "core/io/folder.h"

namespace isthmus::io {

PartFile::PartFile(std::string path) : path_(std::move(path)), part_(path_ + ".part") {}

PartFile::~PartFile() {
  if (file_ != nullptr) std::remove(part_.c_str());
}

absl::Status PartFile::Open() {
  absl::StatusOr<std::unique_ptr<AppendFile>> file = AppendFile::Open(part_);
  if (!file.ok()) return file.status();
  file_ = *std::move(file);
  return file_->Truncate(0);
}

absl::Status PartFile::Append(const std::string& bytes) { return file_->Append(bytes); }

absl::Status PartFile::Commit() {
  // Only what is on the disk may take the place of an older file.
  if (absl::Status status = file_->Sync(); !status.ok()) return status;
  if (std::rename(part_.c_str(), path_.c_str()) != 0) return FileError("make", path_, errno);
  file_ = nullptr;
  return SyncNameOf(path_);
}

absl::Status ReplaceFile(const std::string& path, const std::string& bytes) {
  PartFile file(path);
  absl::Status status = file.Open();
  if (status.ok()) status = file.Append(bytes);
  if (status.ok()) status = file.Commit();
  return status;
}

}  // namespace isthmus::io
