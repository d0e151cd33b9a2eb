// The part of Client that fetches backups.
#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "api/convert/graph.h"
#include "client/library/client.h"
#include "client/library/file_stream.h"
#include "client/library/part_file.h"

namespace isthmus::client {
namespace {

namespace fs = std::filesystem;

// What the folder is called until it is whole; goes again unless it becomes the backup.
class PartFolder {
 public:
  explicit PartFolder(const std::string& folder) : folder_(folder), part_(folder + ".part") {}
  ~PartFolder() {
    std::error_code ignored;
    if (is_made_) fs::remove_all(part_, ignored);
  }
  PartFolder(const PartFolder&) = delete;
  PartFolder& operator=(const PartFolder&) = delete;

  const std::string& path() const { return part_; }

  absl::Status Make() {
    std::error_code error;
    if (fs::exists(folder_, error)) {
      return absl::AlreadyExistsError(
          absl::StrCat(folder_, " exists already; a backup makes its own folder"));
    }
    fs::remove_all(part_, error);  // Of a program that died.
    is_made_ = fs::create_directories(part_, error);
    return is_made_ ? absl::OkStatus() : Failure(error.value(), "make");
  }

  // Names are on the disk only once their folder is synced.
  absl::Status Become() {
    if (absl::Status status = Sync(part_); !status.ok()) return status;
    if (std::rename(part_.c_str(), folder_.c_str()) != 0) return Failure(errno, "rename");
    is_made_ = false;
    return Sync(fs::absolute(folder_).lexically_normal().parent_path().string());
  }

 private:
  absl::Status Failure(int code, const char* action) const {
    return absl::ErrnoToStatus(code, absl::StrCat("cannot ", action, " ", part_));
  }
  absl::Status Sync(const std::string& path) const {
    const int descriptor = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return Failure(errno, "open");
    const absl::Status status = fsync(descriptor) == 0 ? absl::OkStatus() : Failure(errno, "sync");
    close(descriptor);
    return status;
  }

  const std::string folder_, part_;
  bool is_made_ = false;
};

}  // namespace

absl::StatusOr<Backup> Client::BackUp(const std::string& folder,
                                      const std::function<void(const BackupState&)>& progress) {
  PartFolder part(folder);
  if (absl::Status status = part.Make(); !status.ok()) return status;
  PartFile file(part.path() + "/isthmus.db");
  Backup backup;
  const absl::Status status = link_->Repeat(true, [&] {
    absl::Status written = file.Open();
    if (!written.ok()) return written;
    BackupState state;
    const auto note = [&](const v1::BackUpResponse& response) {
      state.copied = std::max(state.copied, response.copied());
      state.total_bytes = std::max(state.total_bytes, response.total_bytes());
      state.bytes += response.data().size();
      if (response.last()) backup.contents = convert::FromMessage(response.contents());
      if (progress) progress(state);
    };
    const auto append = [&](const std::string& bytes) {
      written = file.Append(bytes);
      return written.ok();
    };
    const auto begin = [](Client::Link::Stubs& stubs, grpc::ClientContext& context) {
      return stubs.admin->BackUp(&context, v1::BackUpRequest());
    };
    const absl::Status fetched =
        FetchStream<v1::BackUpResponse>(*link_, begin, append, backup.file, note);
    return written.ok() ? fetched : written;
  });
  if (!status.ok()) return status;
  if (absl::Status kept = file.Commit(); !kept.ok()) return kept;
  if (absl::Status kept = part.Become(); !kept.ok()) return kept;
  return backup;
}

}  // namespace isthmus::client
