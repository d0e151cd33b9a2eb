#include "client/loadgen/server_process.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>
#include <vector>

namespace isthmus::loadgen {

absl::StatusOr<ProcessUse> UseOf(pid_t pid) {
  const std::string folder = absl::StrCat("/proc/", pid);
  std::ifstream file(folder + "/stat");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  // The name stands in parentheses and may hold anything; the numbers follow, see proc(5).
  const size_t name_end = text.rfind(')');
  if (name_end == std::string::npos) {
    return absl::NotFoundError(absl::StrCat("there is no process ", pid, " to watch"));
  }
  const std::vector<std::string> fields = absl::StrSplit(text.substr(name_end + 2), ' ');
  constexpr size_t kUser = 11, kSystem = 12, kThreads = 17, kPages = 21;
  ProcessUse use;
  double user = 0, system = 0, pages = 0;
  if (fields.size() <= kPages || !absl::SimpleAtod(fields[kUser], &user) ||
      !absl::SimpleAtod(fields[kSystem], &system) || !absl::SimpleAtod(fields[kPages], &pages) ||
      !absl::SimpleAtoi(fields[kThreads], &use.threads)) {
    return absl::NotFoundError(absl::StrCat("process ", pid, " cannot be watched"));
  }
  use.cpu_s = (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
  use.resident_mb = pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
  std::error_code error;
  for (std::filesystem::directory_iterator at(folder + "/fd", error), end; at != end && !error;
       at.increment(error)) {
    ++use.files;
  }
  return use;
}

double FolderMb(const std::string& folder) {
  double bytes = 0;
  std::error_code error;
  for (std::filesystem::recursive_directory_iterator at(folder, error), end; at != end && !error;
       at.increment(error)) {
    std::error_code ignored;
    if (at->is_regular_file(ignored)) bytes += static_cast<double>(at->file_size(ignored));
  }
  return bytes / 1e6;
}

}  // namespace isthmus::loadgen
