// An S3-compatible server of a test's own (server.mjs), in a folder that goes with it.
#pragma once

#include <sys/types.h>

#include <memory>
#include <string>
#include <vector>

namespace isthmus::storage {

// Ends with its object, and with the test's process however that ends.
class S3Server {
 public:
  // Sets the credentials in the environment. Fails the test, and gives null, where it does not
  // start.
  static std::unique_ptr<S3Server> Start();
  // The one that all tests of a program share.
  static S3Server& Shared();
  ~S3Server();
  S3Server(const S3Server&) = delete;
  S3Server& operator=(const S3Server&) = delete;

  // The URL of an existing bucket, with a prefix that no other URL has.
  std::string NewUrl();
  std::string origin() const;
  void Kill();
  void Signal(int signal);  // SIGSTOP: it takes requests and answers none.
  // After Kill, at the same port; true once it takes requests.
  bool StartAgain();
  std::string bucket_folder() const { return folder_ + "/data/maps"; }
  // The files that hold objects.
  std::vector<std::string> Objects() const;

 private:
  explicit S3Server(std::string folder) : folder_(std::move(folder)) {}

  const std::string folder_;
  pid_t process_ = 0;
  int port_ = 0;
  int urls_ = 0;
};

}  // namespace isthmus::storage
