// An exception that was caught, as a status.
#pragma once

#include <absl/status/status.h>

#include <exception>
#include <string>
#include <utility>

namespace isthmus {

// An exception that ends work in functions without a status to return: readers that are called for
// a submap and cannot get it now.
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

// The status of the exception that is being handled, so only to be called in a catch block: a
// StatusError's own, ResourceExhausted if memory ran out, else Internal with the exception's words.
//
// Little here throws on purpose; the standard library does when memory runs out, and so may
// libraries. An exception that one record or one caller brings about must not end the process, so
// code that runs work for others (a thread, a task, a handler) catches it and says whose work it
// was.
absl::Status CaughtStatus();

}  // namespace isthmus
