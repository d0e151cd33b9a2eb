// Exit codes of `isthmus`, as docs/cli.md promises them.
#pragma once

#include <absl/status/status.h>

namespace isthmus::cli {

enum ExitCode {
  kOk = 0,
  kFailed = 1,        // Anything that has no code of its own; the message says what.
  kUsage = 2,         // The command line, or a value in it, makes no sense.
  kNoAnswer = 3,      // There is no answer (yet): not merged, not placed, not settled in time.
  kNotReachable = 4,  // No server at that address.
  kInput = 5,         // A file or folder is missing or cannot be used; all scans were rejected.
  kUnknown = 6,  // The server knows no such robot, session, submap, component, loop or revision.
  kLost = 7,     // `odometry`: more than a tenth of the scans were lost, or there is no one frame.
  kRival = 8,    // `merge --unverified`: another alignment is as good as the best one.
  kInterrupted = 130,  // By Ctrl-C or SIGTERM, as shells have it; what was done is said.
};

// For errors that came from the server, and those marked by io::OfFile.
ExitCode ServerExit(const absl::Status& status);

// Prints "isthmus: MESSAGE" to stderr and returns the code.
int Fail(ExitCode code, const absl::Status& status);
// A server's message is one line: the ends of lines in it are of names that it quotes.
int FailServer(const absl::Status& status);
inline int FailInput(const absl::Status& status) { return Fail(kInput, status); }

}  // namespace isthmus::cli
