// Waiting for the server to have an answer.
#pragma once

#include <absl/status/statusor.h>

#include <functional>

#include "client/library/client.h"

namespace isthmus::cli {

enum class WaitFor {
  kSettled,  // The server has nothing left to do.
  kMerged,   // Settled, and all robots, two at least, are in one component.
};

bool IsMerged(const MapInfo& info);

// Asks several times a second until it holds and returns the answer that says so. DeadlineExceeded
// after timeout_s; FailedPrecondition at once when robots are not merged although the server has
// settled and every session is finished: nothing more would come. `seen` receives every answer.
absl::StatusOr<MapInfo> Wait(client::Client& client, WaitFor what, double timeout_s,
                             const std::function<void(const MapInfo&)>& seen = nullptr);

}  // namespace isthmus::cli
