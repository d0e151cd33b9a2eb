// A PostgreSQL server of a test's own, on a socket in a folder that goes with it.
#pragma once

#include <sys/types.h>

#include <memory>
#include <string>

namespace isthmus::storage {

// Ends with its object, and with the test's process however that ends.
class PostgresServer {
 public:
  // Syncs nothing: whoever dies is a process, never the machine. Fails the test, and gives null,
  // where it does not start.
  static std::unique_ptr<PostgresServer> Start();
  // The one that all tests of a program share.
  static PostgresServer& Shared();
  ~PostgresServer();
  PostgresServer(const PostgresServer&) = delete;
  PostgresServer& operator=(const PostgresServer&) = delete;

  std::string url() const { return UrlAt(folder_); }
  // By another socket, in `folder`.
  static std::string UrlAt(const std::string& folder);
  const std::string& folder() const { return folder_; }
  // A name that no site of this server has yet.
  std::string NewSite();
  // kill -9 of the postmaster, whose processes follow it.
  void Kill();
  // After Kill; true once it takes connections.
  bool StartAgain();
  // Runs it as a superuser, in autocommit. False if it fails.
  bool Execute(const std::string& sql);

 private:
  explicit PostgresServer(std::string folder) : folder_(std::move(folder)) {}

  const std::string folder_;
  pid_t postmaster_ = 0;
  int sites_ = 0;
};

}  // namespace isthmus::storage
