// The part of Client that fetches backups.
#include <absl/strings/str_cat.h>
#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <limits>
#include <system_error>

#include "api/convert/graph.h"
#include "client/library/client.h"
#include "client/library/file_stream.h"
#include "core/io/file_io.h"
#include "core/io/folder.h"
#include "core/io/part_file.h"

namespace isthmus::client {
namespace {

namespace fs = std::filesystem;

// Makes the folder under the name that it has until it is whole.
absl::StatusOr<std::string> MakePart(const std::string& folder) {
  std::error_code error;
  if (fs::exists(folder, error)) {
    return absl::AlreadyExistsError(
        absl::StrCat(folder, " exists already; a backup makes its own folder"));
  }
  const std::string part = folder + ".part";
  fs::remove_all(part, error);  // Left by a program that died.
  if (!error) fs::create_directories(part, error);
  if (error) return io::FileError("make", part, error.value());
  return part;
}

// Checks that a backup keeps to the announced length, and that the disk has room for the rest.
absl::Status CheckSize(const BackupState& state, const std::string& folder) {
  if (state.bytes > state.total_bytes) {
    return absl::OutOfRangeError(absl::StrCat("more came than the ", state.total_bytes,
                                              " bytes that the server announced: it is not sound"));
  }
  const io::DiskSpace disk = io::SpaceOf(folder);
  const bool is_known = disk.total_bytes > 0;
  if (!is_known || state.total_bytes - state.bytes <= disk.free_bytes) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("the backup has ", state.total_bytes, " bytes, of which the disk of ", folder,
                   " has room for ", state.bytes + disk.free_bytes, ": name a folder elsewhere"));
}

absl::Status KeepTokens(const std::string& path, const std::string& text) {
  constexpr mode_t kOwnerAlone = 0600;
  const int descriptor = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kOwnerAlone);
  if (descriptor < 0) return io::FileError("write", path, errno);
  io::File file(descriptor, path, io::DiskCalls::System());
  absl::Status status = file.Write(text.data(), text.size(), 0);
  if (status.ok()) status = file.Sync();
  return status.ok() ? file.Close() : status;
}

}  // namespace

absl::StatusOr<Backup> Client::BackUp(const std::string& folder,
                                      const std::function<void(const BackupState&)>& progress,
                                      bool tokens) {
  const absl::StatusOr<std::string> path = MakePart(folder);
  if (!path.ok()) return path.status();
  io::PartFolder part(*path);
  io::PartFile file(part.path() + "/isthmus.db");
  Backup backup;
  std::string token_file;
  const absl::Status status = link_->Repeat(true, [&] {
    absl::Status written = file.Open();
    if (!written.ok()) return NotAgain(written);
    BackupState state;
    const auto note = [&](const v1::BackUpResponse& response) {
      state.copied = std::max(state.copied, response.copied());
      state.total_bytes = std::max(state.total_bytes, response.total_bytes());
      state.bytes += response.data().size();
      if (response.last()) {
        backup.contents = convert::FromMessage(response.contents());
        token_file = response.tokens();
      }
      if (progress) progress(state);
    };
    const auto append = [&](const std::string& bytes) {
      written = CheckSize(state, part.path());
      if (written.ok()) written = file.Append(bytes);
      return written.ok();
    };
    const auto begin = [&](Client::Link::Stubs& stubs, grpc::ClientContext& context) {
      v1::BackUpRequest request;
      request.set_tokens(tokens);
      return stubs.admin->BackUp(&context, request);
    };
    const absl::Status fetched = FetchStream<v1::BackUpResponse>(
        *link_, begin, append, backup.file, std::numeric_limits<uint64_t>::max(), note);
    return written.ok() ? fetched : NotAgain(written);
  });
  if (!status.ok()) return status;
  if (absl::Status kept = file.Commit(); !kept.ok()) return kept;
  backup.has_tokens = !token_file.empty();
  if (backup.has_tokens) {
    if (absl::Status kept = KeepTokens(part.path() + "/tokens", token_file); !kept.ok())
      return kept;
  }
  if (absl::Status kept = part.Become(folder); !kept.ok()) return kept;
  return backup;
}

}  // namespace isthmus::client
