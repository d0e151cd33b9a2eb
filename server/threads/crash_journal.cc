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
#include <utility>
#include <vector>

#include "core/concurrency/mutex.h"
#include "core/io/file_io.h"
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

}  // namespace isthmus::server
