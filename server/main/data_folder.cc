#include "server/main/data_folder.h"

#include <absl/strings/str_cat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

#include "core/io/file_io.h"

namespace isthmus::server {

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

}  // namespace isthmus::server
