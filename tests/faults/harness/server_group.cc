#include "tests/faults/harness/server_group.h"

#include <absl/strings/str_cat.h>
#include <signal.h>
#include <sys/wait.h>

#include <filesystem>
#include <fstream>
#include <utility>

#include "tests/faults/harness/robot.h"
#include "tests/faults/harness/server_process.h"
#include "tests/server/main/child_process.h"

namespace isthmus::faults {

ServerGroup::ServerGroup(const std::string& program, const std::string& folder,
                         const std::vector<std::string>& stores, double lease_s)
    : program_(program), lease_s_(lease_s) {
  for (const std::string& store : stores) {
    auto server = std::make_unique<Server>();
    server->folder = absl::StrCat(folder, "/", servers_.size());
    server->store = store;
    std::filesystem::create_directories(server->folder);
    std::ofstream(server->folder + "/config.yaml")
        << ServerConfigText(8) << "storage: {standby: true, lease_s: " << lease_s_ << "}\n";
    servers_.push_back(std::move(server));
  }
  for (size_t i = 0; i < servers_.size(); ++i) {
    servers_[i]->supervisor = std::thread([this, i] { Supervise(static_cast<int>(i)); });
  }
}

ServerGroup::~ServerGroup() { End(SIGKILL); }

std::string ServerGroup::addresses() const {
  std::string all;
  for (const auto& server : servers_) {
    absl::StrAppend(&all, all.empty() ? "" : ",", "unix:", server->folder, "/robots");
  }
  return all;
}

std::vector<ServerGroup::Owner> ServerGroup::owners() const {
  MutexLock lock(&mutex_);
  return owners_;
}

void ServerGroup::AwaitOwner() const {
  MutexLock lock(&mutex_);
  while (owners_.empty()) changed_.Wait(&mutex_);
}

int ServerGroup::OwnerNow() const {
  MutexLock lock(&mutex_);
  return owners_.empty() || owners_.back().has_ended ? -1 : owners_.back().server;
}

void ServerGroup::Signal(int server, int signal) {
  MutexLock lock(&mutex_);
  const pid_t pid = servers_[static_cast<size_t>(server)]->pid;
  if (pid > 0) kill(pid, signal);
}

std::map<int, int> ServerGroup::ends() const {
  MutexLock lock(&mutex_);
  return ends_;
}

void ServerGroup::Supervise(int index) {
  Server& server = *servers_[static_cast<size_t>(index)];
  for (int run = 0;; ++run) {
    std::unique_ptr<ChildProcess> process;
    {
      MutexLock lock(&mutex_);
      if (is_stopping_) return;
      process = std::make_unique<ChildProcess>(
          program_,
          std::vector<std::string>{"--data", server.folder + "/data", "--listen",
                                   absl::StrCat("unix:", server.folder, "/robots"), "--config",
                                   server.folder + "/config.yaml", "--store", server.store},
          absl::StrCat(server.folder, "/log-", run));
      server.pid = process->pid();
    }
    size_t owned = 0;  // The number of its entry, from 1.
    if (!process->ReadLine().empty()) {
      MutexLock lock(&mutex_);
      owners_.push_back({index, NowS()});
      owned = owners_.size();
      changed_.SignalAll();
    }
    siginfo_t ended = {};
    waitid(P_PID, static_cast<id_t>(process->pid()), &ended, WEXITED | WNOWAIT);
    MutexLock lock(&mutex_);
    server.pid = 0;
    if (owned > 0) owners_[owned - 1].has_ended = true;
    const int code = process->Wait();
    if (code < 128) ++ends_[code];
    constexpr int kTakenOver = 5;
    // The system had not come to the program's first line.
    const bool is_unborn = code == 128 + SIGTERM && process->Errors().empty();
    if (code != 0 && code != kTakenOver && code != 128 + SIGKILL && !is_unborn) {
      absl::StrAppend(&trouble_, "server ", index, " ended with ", code, ": ", process->Errors());
    }
  }
}

void ServerGroup::End(int signal) {
  {
    MutexLock lock(&mutex_);
    is_stopping_ = true;
  }
  for (size_t i = 0; i < servers_.size(); ++i) {
    Signal(static_cast<int>(i), signal);
    Signal(static_cast<int>(i), SIGCONT);
  }
  for (const auto& server : servers_) {
    if (server->supervisor.joinable()) server->supervisor.join();
  }
}

bool ServerGroup::Stop(std::string* why) {
  End(SIGTERM);
  MutexLock lock(&mutex_);
  *why = trouble_;
  return trouble_.empty();
}

}  // namespace isthmus::faults
