#include "client/readers/messages/byte_source.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/io/file_io.h"

namespace isthmus::readers {
namespace {

absl::Status EndsBefore(uint64_t offset, size_t size, uint64_t end) {
  return absl::DataLossError(absl::StrCat("it ends at byte ", end, ", within the ", size,
                                          " bytes from byte ", offset, " on"));
}

bool IsInside(uint64_t offset, size_t size, uint64_t end) {
  return offset <= end && size <= end - offset;
}

class FileBytes : public ByteSource {
 public:
  FileBytes(io::File file, uint64_t size) : file_(std::move(file)), size_(size) {}

  uint64_t size() const override { return size_; }
  absl::Status Read(uint64_t offset, size_t size, char* out) const override {
    if (!IsInside(offset, size, size_)) return EndsBefore(offset, size, size_);
    absl::StatusOr<size_t> read = file_.Read(out, size, offset);
    if (!read.ok()) return read.status();
    return *read == size ? absl::OkStatus() : EndsBefore(offset, size, offset + *read);
  }

 private:
  const io::File file_;
  const uint64_t size_;
};

class BufferBytes : public ByteSource {
 public:
  explicit BufferBytes(std::string bytes) : bytes_(std::move(bytes)) {}

  uint64_t size() const override { return bytes_.size(); }
  absl::Status Read(uint64_t offset, size_t size, char* out) const override {
    if (!IsInside(offset, size, bytes_.size())) return EndsBefore(offset, size, bytes_.size());
    std::memcpy(out, bytes_.data() + offset, size);
    return absl::OkStatus();
  }

 private:
  const std::string bytes_;
};

}  // namespace

absl::StatusOr<std::shared_ptr<const ByteSource>> OpenFileSource(const std::string& path) {
  absl::StatusOr<io::File> file = io::File::Open(path, O_RDONLY);
  if (!file.ok()) return file.status();
  absl::StatusOr<uint64_t> size = file->Size();
  if (!size.ok()) return size.status();
  return std::make_shared<FileBytes>(*std::move(file), *size);
}

std::shared_ptr<const ByteSource> BufferSource(std::string bytes) {
  return std::make_shared<BufferBytes>(std::move(bytes));
}

ByteWindow::ByteWindow(const ByteSource& source, size_t least) : source_(source), least_(least) {}

absl::StatusOr<absl::string_view> ByteWindow::At(uint64_t offset, size_t size) {
  if (offset < begin_ || offset - begin_ > bytes_.size() ||
      bytes_.size() - (offset - begin_) < size) {
    if (!IsInside(offset, size, source_.size())) return EndsBefore(offset, size, source_.size());
    const uint64_t rest = source_.size() - offset;
    const auto wanted = static_cast<size_t>(std::min<uint64_t>(rest, std::max(least_, size)));
    bytes_.resize(wanted);
    begin_ = offset;
    if (absl::Status status = source_.Read(offset, wanted, bytes_.data()); !status.ok()) {
      bytes_.clear();
      return status;
    }
  }
  return absl::string_view(bytes_).substr(offset - begin_, size);
}

}  // namespace isthmus::readers
