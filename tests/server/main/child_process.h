// A program started by a test, with its output.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace isthmus {

class ChildProcess {
 public:
  // Runs `program` with the arguments; its stdout is read here, its stderr goes to a file that
  // Errors() reads.
  ChildProcess(const std::string& program, const std::vector<std::string>& arguments,
               const std::string& error_path);
  ~ChildProcess();  // Kills what still runs.
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // The next line of stdout without its end; empty at the end of the output.
  std::string ReadLine();
  // The rest of stdout.
  std::string ReadAll();
  void Signal(int signal) const;
  pid_t pid() const { return pid_; }
  // Waits for the end: the exit code, or 128 + the signal that ended it.
  int Wait();
  std::string Errors() const;

 private:
  const std::string error_path_;
  pid_t pid_ = -1;
  int stdout_ = -1;
};

}  // namespace isthmus
