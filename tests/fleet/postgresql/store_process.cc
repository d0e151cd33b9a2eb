#include "tests/fleet/postgresql/store_process.h"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>
#include <thread>

#include "fleet/postgresql/postgres_store.h"
#include "tests/storage/records.h"

namespace {

std::chrono::seconds clock_ahead{0};

}  // namespace

// In place of the C library's, for a clock that is wrong.
extern "C" int clock_gettime(clockid_t clock, timespec* now) noexcept {
  const long result = syscall(SYS_clock_gettime, clock, now);
  if (clock == CLOCK_REALTIME) now->tv_sec += clock_ahead.count();
  return static_cast<int>(result);
}

namespace isthmus::storage {
namespace {

[[noreturn]] void Run(const StoreProcessOptions& options, int told) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  clock_ahead = options.clock_ahead;
  PostgresOptions store_options;
  store_options.lease.length = options.lease;
  if (options.stands_by) store_options.lease.on_wait = [](const std::string&) { return true; };
  store_options.lease.on_lost = [](const std::string&) { _exit(kLostTheSite); };
  const auto store = OpenPostgresStore(options.url, options.site, store_options);
  if (!store.ok()) _exit(1);
  for (int i = 1;; ++i) {
    const std::string id = options.name + "-" + std::to_string(i);
    const absl::Status status = (*store)->Write({.sessions = {MakeSession(id)}});
    const std::string line = id + "\n";
    if (status.ok() && write(told, line.data(), line.size()) < 0) _exit(2);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));  // Its robots send no faster.
  }
}

}  // namespace

StoreProcess::StoreProcess(const StoreProcessOptions& options) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("pipe failed");
  pid_ = fork();
  if (pid_ == 0) Run(options, ends[1]);
  close(ends[1]);
  told_ = ends[0];
}

StoreProcess::~StoreProcess() {
  if (pid_ > 0) {
    Signal(SIGKILL);
    Wait();
  }
  close(told_);
}

std::optional<std::string> StoreProcess::Next() {
  std::string id;
  for (char c = 0; read(told_, &c, 1) == 1;) {
    if (c == '\n') return id;
    id += c;
  }
  return std::nullopt;
}

std::vector<std::string> StoreProcess::Rest() {
  std::vector<std::string> ids;
  while (auto id = Next()) ids.push_back(*std::move(id));
  return ids;
}

void StoreProcess::Signal(int signal) const { kill(pid_, signal); }

int StoreProcess::Wait() {
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace isthmus::storage
