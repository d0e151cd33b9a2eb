#include "tests/faults/harness/worker_group.h"

#include <absl/strings/str_cat.h>
#include <signal.h>
#include <sys/wait.h>

#include <filesystem>
#include <memory>

#include "tests/server/main/child_process.h"

namespace isthmus::faults {

WorkerGroup::WorkerGroup(const std::string& program, const std::string& folder,
                         const std::vector<std::string>& stores)
    : program_(program), folder_(folder), pids_(stores.size()) {
  std::filesystem::create_directories(folder);
  for (size_t i = 0; i < stores.size(); ++i) {
    supervisors_.emplace_back(
        [this, i, store = stores[i]] { Supervise(static_cast<int>(i), store); });
  }
}

WorkerGroup::~WorkerGroup() { End(SIGKILL); }

void WorkerGroup::Kill(int worker) {
  MutexLock lock(&mutex_);
  const pid_t pid = pids_[static_cast<size_t>(worker)];
  if (pid > 0) kill(pid, SIGKILL);
}

void WorkerGroup::Supervise(int index, const std::string& store) {
  for (int run = 0;; ++run) {
    std::unique_ptr<ChildProcess> process;
    {
      MutexLock lock(&mutex_);
      if (is_stopping_) return;
      process =
          std::make_unique<ChildProcess>(program_, std::vector<std::string>{"--store", store},
                                         absl::StrCat(folder_, "/worker-", index, "-log-", run));
      pids_[static_cast<size_t>(index)] = process->pid();
    }
    siginfo_t ended = {};
    waitid(P_PID, static_cast<id_t>(process->pid()), &ended, WEXITED | WNOWAIT);
    MutexLock lock(&mutex_);
    pids_[static_cast<size_t>(index)] = 0;
    const int code = process->Wait();
    if (code != 0 && code != 128 + SIGKILL) {
      absl::StrAppend(&trouble_, "worker ", index, " ended with ", code, ": ", process->Errors());
    }
  }
}

void WorkerGroup::End(int signal) {
  {
    MutexLock lock(&mutex_);
    is_stopping_ = true;
    for (const pid_t pid : pids_) {
      if (pid > 0) kill(pid, signal);
    }
  }
  for (std::thread& supervisor : supervisors_) {
    if (supervisor.joinable()) supervisor.join();
  }
}

bool WorkerGroup::Stop(std::string* why) {
  End(SIGTERM);
  MutexLock lock(&mutex_);
  *why = trouble_;
  return trouble_.empty();
}

}  // namespace isthmus::faults
