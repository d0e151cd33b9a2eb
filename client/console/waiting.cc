#include "client/console/waiting.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "core/stopwatch.h"

namespace isthmus::cli {
namespace {

constexpr std::chrono::milliseconds kInterval(200);

// True when no session takes scans any more.
absl::StatusOr<bool> AllFinished(client::Client& client) {
  const auto sessions = client.ListSessions();
  if (!sessions.ok()) return sessions.status();
  return std::all_of(sessions->begin(), sessions->end(), [](const SessionStatus& session) {
    return session.record.state == SessionState::kFinished;
  });
}

std::string Describe(const MapInfo& info) {
  return absl::StrCat(info.robots.size(), " robots in ", info.components.size(), " maps");
}

}  // namespace

bool IsMerged(const MapInfo& info) {
  return info.robots.size() >= 2 &&
         std::any_of(info.components.begin(), info.components.end(),
                     [&](const Component& component) {
                       return component.robots.size() == info.robots.size();
                     });
}

absl::StatusOr<MapInfo> Wait(client::Client& client, WaitFor what, double timeout_s,
                             const std::function<void(const MapInfo&)>& seen) {
  const Stopwatch watch;
  for (;;) {
    absl::StatusOr<MapInfo> info = client.GetMapInfo();
    if (!info.ok()) return info;
    if (seen) seen(*info);
    if (info->settled && (what == WaitFor::kSettled || IsMerged(*info))) return info;
    if (info->settled) {
      const absl::StatusOr<bool> finished = AllFinished(client);
      if (!finished.ok()) return finished.status();
      if (*finished) {
        return absl::FailedPreconditionError(
            absl::StrCat("not merged: ", Describe(*info), ", and no session is open any more; ",
                         "`isthmus graph` shows the reasons of the matches"));
      }
    }
    if (watch.Ms() >= timeout_s * 1000) {
      return absl::DeadlineExceededError(absl::StrCat(
          "not ", what == WaitFor::kSettled ? "settled" : "merged", " after ", timeout_s,
          " s: ", Describe(*info), info->settled ? "" : "; the server is still at work"));
    }
    std::this_thread::sleep_for(kInterval);
  }
}

}  // namespace isthmus::cli
