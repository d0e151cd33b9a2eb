#include "tests/fleet/postgresql/postgres_server.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <libpq-fe.h>
#include <pwd.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <thread>
#include <vector>

namespace isthmus::storage {
namespace {

constexpr char kPrograms[] = "/usr/lib/postgresql/15/bin/";
constexpr char kUser[] = "nobody";  // PostgreSQL refuses to run as root.

pid_t Spawn(const std::string& folder, const std::vector<std::string>& command) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const passwd* user = geteuid() == 0 ? getpwnam(kUser) : nullptr;
  const std::string log = folder + "/log";
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child != 0) return child;
  if (user != nullptr && (setgid(user->pw_gid) != 0 || setuid(user->pw_uid) != 0)) _exit(126);
  prctl(PR_SET_PDEATHSIG, SIGQUIT);
  if (getppid() != parent) _exit(125);
  const int out = open(log.c_str(), O_CREAT | O_APPEND | O_WRONLY, 0600);
  dup2(out, 1);
  dup2(out, 2);
  execv(arguments[0], arguments.data());
  _exit(127);
}

int WaitFor(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

}  // namespace

std::string PostgresServer::UrlAt(const std::string& folder) {
  return "postgresql:///postgres?user=isthmus&host=" + folder;
}

std::unique_ptr<PostgresServer> PostgresServer::Start() {
  std::string folder = "/tmp/isthmus-postgres-XXXXXX";  // Short: it is in a socket's path.
  if (mkdtemp(folder.data()) == nullptr) return nullptr;
  std::unique_ptr<PostgresServer> server(new PostgresServer(folder));
  if (const passwd* user = getpwnam(kUser); geteuid() == 0 && user != nullptr) {
    EXPECT_EQ(chown(folder.c_str(), user->pw_uid, user->pw_gid), 0);
  }
  const int status =
      WaitFor(Spawn(folder, {std::string(kPrograms) + "initdb", "-D", folder + "/data", "-U",
                             "isthmus", "-A", "trust", "-E", "UTF8", "--locale=C", "--no-sync"}));
  EXPECT_EQ(status, 0) << "initdb failed; is postgresql-15 installed?";
  if (status != 0 || !server->StartAgain()) return nullptr;
  return server;
}

PostgresServer& PostgresServer::Shared() {
  static const std::unique_ptr<PostgresServer> kServer = Start();
  if (kServer == nullptr) abort();
  return *kServer;
}

PostgresServer::~PostgresServer() {
  if (postmaster_ > 0) {
    kill(postmaster_, SIGCONT);
    kill(postmaster_, SIGQUIT);
    WaitFor(postmaster_);
  }
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

std::string PostgresServer::NewSite() { return "test" + std::to_string(++sites_); }

void PostgresServer::Kill() {
  kill(postmaster_, SIGKILL);
  WaitFor(postmaster_);
  postmaster_ = 0;
}

bool PostgresServer::StartAgain() {
  using std::chrono::steady_clock;
  const auto until = steady_clock::now() + std::chrono::seconds(60);
  while (steady_clock::now() < until) {
    if (postmaster_ > 0 && waitpid(postmaster_, nullptr, WNOHANG) == postmaster_) postmaster_ = 0;
    // It does not start while processes of the one before are still about to end.
    if (postmaster_ == 0) {
      postmaster_ = Spawn(folder_, {std::string(kPrograms) + "postgres", "-D", folder_ + "/data",
                                    "-k", folder_, "-c", "listen_addresses=", "-c", "fsync=off",
                                    "-c", "shared_buffers=16MB", "-c", "max_connections=200"});
    }
    if (PQping(url().c_str()) == PQPING_OK) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // For another process.
  }
  ADD_FAILURE() << "PostgreSQL does not start";
  return false;
}

bool PostgresServer::Execute(const std::string& sql) {
  PGconn* connection = PQconnectdb(url().c_str());
  PGresult* result = PQexec(connection, sql.c_str());
  const ExecStatusType status = PQresultStatus(result);
  const bool done = status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK;
  if (!done) ADD_FAILURE() << sql << ": " << PQerrorMessage(connection);
  PQclear(result);
  PQfinish(connection);
  return done;
}

}  // namespace isthmus::storage
