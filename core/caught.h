// An exception that was caught, as a status.
#pragma once

#include <absl/status/status.h>

namespace isthmus {

// Of the exception that is being handled, so only to be called in a catch block:
// ResourceExhausted where memory ran out, else Internal with what the exception says of itself.
//
// Nothing here throws on purpose; the standard library does where memory runs out, and so may
// libraries. What one record or one caller brings about so must not end the process, so whoever
// runs work for others (a thread, a task, a handler) catches what comes and says whose it was.
absl::Status CaughtStatus();

}  // namespace isthmus
