#include "tests/fleet/objects/s3_server.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>
#include <utility>

namespace isthmus::storage {

std::unique_ptr<S3Server> S3Server::Start() {
  setenv("AWS_ACCESS_KEY_ID", "S3RVER", 1);  // The key that it takes.
  setenv("AWS_SECRET_ACCESS_KEY", "S3RVER", 1);
  unsetenv("AWS_SESSION_TOKEN");
  std::string folder = "/tmp/isthmus-s3-XXXXXX";
  if (mkdtemp(folder.data()) == nullptr) return nullptr;
  std::unique_ptr<S3Server> server(new S3Server(folder));
  return server->StartAgain() ? std::move(server) : nullptr;
}

S3Server& S3Server::Shared() {
  static const std::unique_ptr<S3Server> kServer = Start();
  if (kServer == nullptr) abort();
  return *kServer;
}

S3Server::~S3Server() {
  Kill();
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

std::string S3Server::origin() const { return "http://127.0.0.1:" + std::to_string(port_); }

std::string S3Server::NewUrl() { return origin() + "/maps/test" + std::to_string(++urls_); }

void S3Server::Signal(int signal) { kill(process_, signal); }

void S3Server::Kill() {
  if (process_ <= 0) return;
  kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
  process_ = 0;
}

bool S3Server::StartAgain() {
  const std::string port = std::to_string(port_), log = folder_ + "/log", data = folder_ + "/data";
  std::filesystem::create_directories(data);
  std::filesystem::remove(log);
  const pid_t parent = getpid();
  process_ = fork();
  if (process_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(125);
    const int out = open(log.c_str(), O_CREAT | O_WRONLY, 0600);
    dup2(out, 1);
    dup2(out, 2);
    if (chdir(ISTHMUS_S3_PACKAGES) != 0) _exit(126);
    // s3rver encrypts where a page of a list ends, by what OpenSSL 3 has for old programs only.
    execlp("node", "node", "--openssl-legacy-provider", "server.mjs", port.c_str(), data.c_str(),
           nullptr);
    _exit(127);
  }
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (std::chrono::steady_clock::now() < until) {
    std::ifstream said(log);
    for (std::string line; std::getline(said, line);) {
      const size_t at = line.rfind(':');
      if (line.find("listening on") == std::string::npos || said.eof()) continue;
      port_ = std::stoi(line.substr(at + 1));
      return true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // For another process.
  }
  ADD_FAILURE() << "the S3 server does not start; are npm and node installed?";
  return false;
}

std::vector<std::string> S3Server::Objects() const {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_ + "/data")) {
    if (entry.path().string().ends_with("._S3rver_object")) files.push_back(entry.path());
  }
  return files;
}

}  // namespace isthmus::storage
