#include "server/threads/crash_journal.h"

#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/strings/str_split.h>
#include <absl/strings/string_view.h>
#include <absl/strings/strip.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "core/caught.h"
#include "core/concurrency/mutex.h"
#include "core/io/file_io.h"
#include "server/jobs/await_store.h"
#include "server/threads/limits.h"

namespace isthmus::server {
namespace {

constexpr absl::string_view kVersionMark = "version ", kBootMark = "boot ",
                            kAtHandMark = "at_hand ", kCrashedMark = "crashed ";

}  // namespace

CrashJournal::CrashJournal(std::string path, std::string boot, std::string version)
    : path_(std::move(path)), boot_(std::move(boot)), version_(std::move(version)) {
  if (path_.empty()) return;
  Load();
  Save("");
}

std::string CrashJournal::BootId() {
  auto id = io::ReadFile("/proc/sys/kernel/random/boot_id");
  return id.ok() ? std::string(absl::StripAsciiWhitespace(*id)) : "";
}

std::string CrashJournal::Version() { return ISTHMUS_VERSION; }

void CrashJournal::Load() {
  const auto text = io::ReadFile(path_);
  if (!text.ok()) return;
  std::string version, boot, at_hand;
  for (absl::string_view line : absl::StrSplit(*text, '\n')) {
    if (absl::ConsumePrefix(&line, kVersionMark)) {
      version = std::string(line);
    } else if (absl::ConsumePrefix(&line, kBootMark)) {
      boot = std::string(line);
    } else if (absl::ConsumePrefix(&line, kAtHandMark)) {
      at_hand = std::string(line);
    } else if (absl::ConsumePrefix(&line, kCrashedMark)) {
      const std::pair<std::string, std::string> entry =
          absl::StrSplit(line, absl::MaxSplits(' ', 1));
      int count = 0;
      if (absl::SimpleAtoi(entry.first, &count)) crashes_[entry.second] = count;
    }
  }
  if (version != version_) crashes_.clear();
  if (at_hand.empty()) {
    for (auto& [task, count] : crashes_) count = std::min(count, kMaxCrashes - 1);
  } else if (version == version_ && boot == boot_) {
    ++crashes_[at_hand];
  }
}

void CrashJournal::Save(const std::string& at_hand) {
  if (path_.empty()) return;
  MutexLock lock(&mutex_);
  std::string text = absl::StrCat(kVersionMark, version_, "\n", kBootMark, boot_, "\n");
  for (const auto& [task, count] : crashes_)
    absl::StrAppend(&text, kCrashedMark, count, " ", task, "\n");
  if (!at_hand.empty()) absl::StrAppend(&text, kAtHandMark, at_hand, "\n");
  if (text == saved_) return;
  saved_ = io::WriteFile(path_, text).ok() ? std::move(text) : "";
}

std::vector<std::string> CrashJournal::ended_at() const {
  std::vector<std::string> tasks;
  for (const auto& [task, count] : crashes_) tasks.push_back(task);
  return tasks;
}

bool CrashJournal::IsQuarantined(const std::string& task, absl::Duration since_start) const {
  const auto it = crashes_.find(task);
  if (it == crashes_.end() || it->second < kMaxCrashes) return false;
  absl::Duration left_out = kLeftOutAfterCrashes;
  for (int i = kMaxCrashes; i < it->second && left_out < kLeftOutAtMost; ++i) left_out *= 2;
  return since_start < std::min(left_out, kLeftOutAtMost);
}

void CrashJournal::ClearBlame(const std::string& path) {
  const auto text = io::ReadFile(path);
  if (!text.ok()) return;
  std::vector<absl::string_view> lines = absl::StrSplit(*text, '\n');
  std::erase_if(lines, [](absl::string_view line) { return absl::StartsWith(line, kAtHandMark); });
  (void)io::WriteFile(path, absl::StrJoin(lines, "\n"));
}

void CrashJournal::BeginTask(const std::string& task) { Save(task); }

void CrashJournal::EndTask() { Save(""); }

WorkGuard::WorkGuard(const std::string& journal, const Clock* clock, std::stop_token stop,
                     std::function<void(const std::string& problem)> on_problem)
    : journal_(journal),
      clock_(clock),
      started_ns_(clock->NowNs()),
      stop_(std::move(stop)),
      on_problem_(std::move(on_problem)) {}

bool WorkGuard::IsLeftOut(const JobKey& key) const {
  return journal_.IsQuarantined(ToText(key), absl::Nanoseconds(clock_->NowNs() - started_ns_));
}

bool WorkGuard::Run(const JobKey& key, const std::function<void()>& work) {
  std::string problem;
  if (IsLeftOut(key)) {
    ended_at_.insert(key);
    left_out_ = ended_at_.size();
    problem =
        absl::StrCat("the server ended while it was at that, ", kMaxCrashes,
                     " times; it is tried once more in a while, and at once after the server was "
                     "stopped in order and started. If nobody killed it, please report this");
  } else {
    journal_.BeginTask(ToText(key));
    try {
      work();
    } catch (const Stopped&) {
      problem = "stopped";
    } catch (...) {
      problem = std::string(CaughtStatus().message());
    }
    journal_.EndTask();
  }
  if (problem.empty()) return true;
  if (!stop_.stop_requested()) (void)Tell(key, problem);
  return false;
}

void WorkGuard::TryAgain(const std::function<void(const JobKey& key)>& is_due) {
  std::erase_if(ended_at_, [&](const JobKey& key) {
    if (IsLeftOut(key)) return false;
    is_due(key);
    return true;
  });
  left_out_ = ended_at_.size();
}

bool WorkGuard::Tell(const JobKey& key, const std::string& problem) {
  const bool is_first = told_.insert(key).second;
  if (is_first) on_problem_(absl::StrCat("left out ", Describe(key), ": ", problem));
  return is_first;
}

std::vector<JobKey> WorkGuard::ended_at() const {
  std::vector<JobKey> keys;
  for (const std::string& task : journal_.ended_at()) {
    if (const std::optional<JobKey> key = ParseJobKey(task)) keys.push_back(*key);
  }
  return keys;
}

}  // namespace isthmus::server
