#include "lab/loadgen/server_process.h"

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

namespace {

// The name and the numbers of a stat file of /proc; empty numbers where there is none.
struct StatLine {
  std::string name;
  std::vector<std::string> fields;
};

StatLine ReadStat(const std::string& path) {
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  // The name stands in parentheses and may hold anything; the numbers follow, see proc(5).
  const size_t name = text.find('('), name_end = text.rfind(')');
  if (name_end == std::string::npos) return {};
  return {text.substr(name + 1, name_end - name - 1),
          absl::StrSplit(text.substr(name_end + 2), ' ')};
}

double NumberAt(const StatLine& stat, size_t field) {
  double number = 0;
  return field < stat.fields.size() && absl::SimpleAtod(stat.fields[field], &number) ? number : 0;
}

double CpuOf(const StatLine& stat) {
  constexpr size_t kUser = 11, kSystem = 12;
  return (NumberAt(stat, kUser) + NumberAt(stat, kSystem)) /
         static_cast<double>(sysconf(_SC_CLK_TCK));
}

}  // namespace

absl::StatusOr<ProcessUse> UseOf(pid_t pid) {
  const std::string folder = absl::StrCat("/proc/", pid);
  const StatLine stat = ReadStat(folder + "/stat");
  if (stat.fields.empty()) {
    return absl::NotFoundError(absl::StrCat("there is no process ", pid, " to watch"));
  }
  constexpr size_t kThreads = 17, kPages = 21;
  ProcessUse use;
  use.cpu_s = CpuOf(stat);
  use.threads = static_cast<int>(NumberAt(stat, kThreads));
  use.resident_mb = NumberAt(stat, kPages) * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
  std::error_code error;
  for (std::filesystem::directory_iterator at(folder + "/fd", error), end; at != end && !error;
       at.increment(error)) {
    ++use.files;
  }
  return use;
}

std::map<std::string, double> ThreadCpuS(pid_t pid) {
  std::map<std::string, double> cpu_s;
  std::error_code error;
  const std::string folder = absl::StrCat("/proc/", pid, "/task");
  for (std::filesystem::directory_iterator at(folder, error), end; at != end && !error;
       at.increment(error)) {
    const StatLine stat = ReadStat((at->path() / "stat").string());
    if (!stat.fields.empty()) cpu_s[stat.name] += CpuOf(stat);
  }
  return cpu_s;
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
