#include "server/main/data_folder.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/io/file_io.h"

namespace isthmus::server {
namespace {

std::string NoteIn(const std::string& folder) { return folder + "/map-is-elsewhere"; }

// Files of a map are never there before its database.
absl::Status CheckNothingIsLeft(const std::string& folder) {
  std::vector<std::string> left;
  for (const char* name :
       {"composed.points", "composed.index", "scans", "isthmus.db-wal", "isthmus.open"}) {
    std::error_code error;
    const std::string path = absl::StrCat(folder, "/", name);
    if (!std::filesystem::is_empty(path, error) && !error) left.push_back(path);
  }
  if (left.empty()) return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(
      folder,
      "/isthmus.db is missing or empty, but files of a map are there: its database was "
      "lost. Nothing was changed; restore a backup, or move ",
      absl::StrJoin(left, ", "), " away to begin with an empty map"));
}

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
  const std::uintmax_t size = std::filesystem::file_size(path + "/isthmus.db", error);
  if (!error && size > 0) return absl::OkStatus();
  if (!std::filesystem::exists(NoteIn(path), error)) return CheckNothingIsLeft(path);
  const auto database = io::ReadFile(NoteIn(path));
  if (!database.ok()) return database.status();
  return absl::FailedPreconditionError(
      absl::StrCat("the map of ", path, " is kept in ", absl::StripAsciiWhitespace(*database),
                   ": start with --store (storage.store), or remove ", NoteIn(path),
                   " to begin another map here"));
}

}  // namespace isthmus::server
