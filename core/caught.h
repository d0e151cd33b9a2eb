// An exception that was caught, as a status.
#pragma once

#include <absl/status/status.h>

#include <exception>
#include <string>
#include <utility>

namespace isthmus {

// What ends work in the midst of functions that have no status to return: readers that are called
// for a submap and cannot get it now.
class StatusError : public std::exception {
 public:
  explicit StatusError(absl::Status status)
      : status_(std::move(status)), message_(status_.message()) {}
  const absl::Status& status() const { return status_; }
  const char* what() const noexcept override { return message_.c_str(); }

 private:
  const absl::Status status_;
  const std::string message_;
};

// Of the exception that is being handled, so only to be called in a catch block: that of a
// StatusError, ResourceExhausted where memory ran out, else Internal with what the exception says
// of itself.
//
// Little here throws on purpose; the standard library does where memory runs out, and so may
// libraries. What one record or one caller brings about so must not end the process, so whoever
// runs work for others (a thread, a task, a handler) catches what comes and says whose it was.
absl::Status CaughtStatus();

}  // namespace isthmus
