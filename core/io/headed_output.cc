#include "core/io/headed_output.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "core/io/folder.h"

namespace isthmus::io {
namespace {

constexpr uint64_t kBodyPiece = uint64_t{1} << 20;

// A file that is gone with its descriptor.
absl::StatusOr<File> UnnamedFile() {
  std::string name = (std::filesystem::temp_directory_path() / "isthmus-XXXXXX").string();
  const int descriptor = mkstemp(name.data());
  if (descriptor < 0) return FileError("make", name, errno);
  unlink(name.c_str());
  return File(descriptor, name, DiskCalls::System());
}

}  // namespace

HeadedOutput::HeadedOutput(const std::string& path, uint64_t head_size)
    : path_(OutputTarget(path)), head_size_(head_size) {
  stream_.emplace(path);
  if (stream_->is_stream()) return;
  stream_.reset();
  part_ = path_ + ".part";
}

HeadedOutput::~HeadedOutput() {
  if (body_ && !part_.empty()) std::remove(part_.c_str());
}

absl::Status HeadedOutput::Open() {
  absl::StatusOr<File> body =
      stream_ ? UnnamedFile() : File::Open(part_, O_RDWR | O_CREAT | O_TRUNC);
  if (!body.ok()) return body.status();
  body_ = *std::move(body);
  size_ = 0;
  return stream_ ? stream_->Open() : absl::OkStatus();
}

absl::Status HeadedOutput::Append(const std::string& bytes) {
  const absl::Status status = body_->Write(bytes.data(), bytes.size(), head_size_ + size_);
  if (status.ok()) size_ += bytes.size();
  return status;
}

absl::Status HeadedOutput::SendBody() {
  std::string piece;
  for (uint64_t done = 0; done < size_; done += piece.size()) {
    piece.resize(std::min(kBodyPiece, size_ - done));
    const auto got = body_->Read(piece.data(), piece.size(), head_size_ + done);
    if (!got.ok()) return got.status();
    if (absl::Status status = stream_->Append(piece); !status.ok()) return status;
  }
  return stream_->Commit();
}

absl::Status HeadedOutput::Commit(const std::string& head) {
  if (head.size() != head_size_) {
    return absl::InvalidArgumentError(absl::StrCat("the head of ", path_, " has ", head.size(),
                                                   " bytes; there is room for ", head_size_));
  }
  if (stream_) {
    const absl::Status status = stream_->Append(head);
    return status.ok() ? SendBody() : status;
  }
  absl::Status status = body_->Write(head.data(), head.size(), 0);
  if (status.ok()) status = body_->Sync();
  if (!status.ok()) return status;
  if (std::rename(part_.c_str(), path_.c_str()) != 0) return FileError("make", path_, errno);
  part_.clear();
  return SyncNameOf(path_);
}

}  // namespace isthmus::io
