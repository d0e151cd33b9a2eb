#include "server/main/data_folder.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

#include "core/io/file_io.h"

namespace isthmus::server {
namespace {

std::string NoteIn(const std::string& folder) { return folder + "/map-is-elsewhere"; }

}  // namespace

absl::Status MakeDataFolder(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) {
    return absl::FailedPreconditionError(
        absl::StrCat("cannot make the data folder ", path, ": ", error.message()));
  }
  if (!std::filesystem::is_directory(path, error)) {
    return absl::FailedPreconditionError(
        absl::StrCat("the data folder ", path, " is not a folder: name another with --data"));
  }
  if (access(path.c_str(), R_OK | W_OK | X_OK) != 0) {
    return absl::FailedPreconditionError(absl::StrCat("cannot write in the data folder ", path,
                                                      ": ", io::Explain(errno),
                                                      ", or name another with --data"));
  }
  return absl::OkStatus();
}

absl::Status NoteMapIsIn(const std::string& path, const std::string& database) {
  return io::WriteFile(NoteIn(path), database + "\n");
}

absl::Status CheckMapIsHere(const std::string& path) {
  std::error_code error;
  if (std::filesystem::exists(path + "/isthmus.db", error)) return absl::OkStatus();
  if (!std::filesystem::exists(NoteIn(path), error)) return absl::OkStatus();
  const auto database = io::ReadFile(NoteIn(path));
  if (!database.ok()) return database.status();
  return absl::FailedPreconditionError(
      absl::StrCat("the map of ", path, " is kept in ", absl::StripAsciiWhitespace(*database),
                   ": start with --store (storage.store), or remove ", NoteIn(path),
                   " to begin another map here"));
}

}  // namespace isthmus::server
