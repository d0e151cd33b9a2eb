#include "core/io/process_use.h"

#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <iterator>
#include <memory>
#include <system_error>

namespace isthmus::io {
namespace {

namespace fs = std::filesystem;

uint64_t CountEntries(const char* folder) {
  std::error_code error;
  uint64_t count = 0;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    ++count;
  }
  return count;
}

uint64_t ResidentBytes() {
  const std::unique_ptr<FILE, int (*)(FILE*)> file(std::fopen("/proc/self/statm", "r"),
                                                   &std::fclose);
  unsigned long long all = 0, resident = 0;
  if (file == nullptr || std::fscanf(file.get(), "%llu %llu", &all, &resident) != 2) return 0;
  return resident * static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
}

double Seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

}  // namespace

ProcessUse UseOfThisProcess() {
  ProcessUse use;
  rusage used = {};
  if (::getrusage(RUSAGE_SELF, &used) == 0) {
    use.cpu_s = Seconds(used.ru_utime) + Seconds(used.ru_stime);
  }
  use.resident_bytes = ResidentBytes();
  use.threads = CountEntries("/proc/self/task");
  use.open_files = CountEntries("/proc/self/fd");
  if (use.open_files > 0) --use.open_files;  // The listing opens one itself.
  rlimit limit = {};
  if (::getrlimit(RLIMIT_NOFILE, &limit) == 0) use.open_files_limit = limit.rlim_cur;
  return use;
}

}  // namespace isthmus::io
