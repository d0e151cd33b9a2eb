#include "core/io/output_file.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/strip.h>
#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

namespace isthmus::io {
namespace {

namespace fs = std::filesystem;

// The descriptor that the name stands for; -1: none. By name, because /dev/stdout leads to a file
// where a shell redirects it.
int DescriptorOf(absl::string_view path) {
  if (path == "-" || path == "/dev/stdout") return STDOUT_FILENO;
  if (path == "/dev/stderr") return STDERR_FILENO;
  int descriptor = -1;
  const bool is_number =
      (absl::ConsumePrefix(&path, "/dev/fd/") || absl::ConsumePrefix(&path, "/proc/self/fd/")) &&
      absl::SimpleAtoi(path, &descriptor);
  return is_number ? descriptor : -1;
}

bool IsStream(const std::string& path) {
  if (DescriptorOf(path) >= 0) return true;
  std::error_code none;
  const fs::file_status status = fs::status(path, none);
  return fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status);
}

}  // namespace

std::string OutputTarget(const std::string& path) {
  std::error_code error;
  if (!fs::is_symlink(path, error)) return path;
  const fs::path target = fs::weakly_canonical(path, error);
  return error ? path : target.string();
}

OutputFile::OutputFile(const std::string& path) : path_(path) {
  if (!IsStream(path)) part_.emplace(OutputTarget(path));
}

absl::Status OutputFile::Open() {
  if (part_) return part_->Open();
  if (has_bytes_) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot begin ", path_, " anew: a part of it is written; run it again"));
  }
  if (stream_) return absl::OkStatus();
  const int descriptor = DescriptorOf(path_);
  const int copy = descriptor >= 0 ? fcntl(descriptor, F_DUPFD_CLOEXEC, 0)
                                   : open(path_.c_str(), O_WRONLY | O_CLOEXEC);
  if (copy < 0) return FileError("write", path_, errno);
  stream_.emplace(copy, path_, DiskCalls::Streams());
  return absl::OkStatus();
}

absl::Status OutputFile::Append(const std::string& bytes) {
  if (part_) return part_->Append(bytes);
  has_bytes_ = true;
  return stream_->Write(bytes.data(), bytes.size(), 0);
}

absl::Status OutputFile::Commit() {
  if (part_) return part_->Commit();
  return stream_->Close();
}

bool IsStandardOutput(const std::string& path) { return DescriptorOf(path) == STDOUT_FILENO; }

absl::Status CheckOutput(const std::string& path) {
  if (IsStream(path)) return absl::OkStatus();
  std::error_code none;
  if (fs::is_directory(path, none)) return FileError("write", path, EISDIR);
  const fs::path folder = fs::path(OutputTarget(path)).parent_path();
  const std::string at = folder.empty() ? "." : folder.string();
  if (!fs::is_directory(at, none)) {
    return absl::NotFoundError(
        absl::StrCat("cannot write ", path, ": there is no folder ", at, "; make it first"));
  }
  return access(at.c_str(), W_OK) == 0 ? absl::OkStatus() : FileError("write", path, errno);
}

absl::Status WriteOutput(const std::string& path, const std::string& bytes) {
  if (absl::Status status = CheckOutput(path); !status.ok()) return status;
  OutputFile file(path);
  absl::Status status = file.Open();
  if (status.ok()) status = file.Append(bytes);
  if (status.ok()) status = file.Commit();
  return status;
}

}  // namespace isthmus::io
