// A journal on disk of the work in progress, which reveals work that crashes the server, and the
// guard that leaves it out.
#pragma once

#include <absl/time/time.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "core/clock.h"
#include "core/concurrency/mutex.h"
#include "server/jobs/job_key.h"

namespace isthmus::server {

// A pair or a submap that made the server crash would do so again at every start, as it is taken up
// again at every start. Work that was in progress at kMaxCrashes of them is left out from then on,
// until a process has ended with nothing at hand, as when it is stopped in order, or for
// kLeftOutAfterCrashes and longer with each further crash: then it is tried once more, since a
// process killed from outside cannot be told from one that crashed.
//
// Crashes are what ended the process but not the machine: after a power cut the number of the boot
// is different, and no task is blamed. Counts hold for one version of the program. Errors of the
// file are ignored: without it the server works as well. Thread safe.
class CrashJournal {
 public:
  // Counts the work that the last process left unfinished. With an empty path nothing is kept.
  explicit CrashJournal(std::string path) : CrashJournal(std::move(path), BootId(), Version()) {}
  CrashJournal(std::string path, std::string boot, std::string version);

  // The work that was in progress when a process ended, left out or not.
  std::vector<std::string> ended_at() const;
  // True where `task`, one line, is left out so long after the start.
  bool IsQuarantined(const std::string& task,
                     absl::Duration since_start = absl::ZeroDuration()) const;
  void BeginTask(const std::string& task);
  // Also when the work is ordered to stop: what ends the process from then on is not its fault.
  void EndTask();
  // Clears the work at hand in the journal at `path`, whoever has it open: a process that is about
  // to end itself says that this work is not to blame.
  static void ClearBlame(const std::string& path);

 private:
  static std::string BootId();
  static std::string Version();
  void Load();
  void Save(const std::string& at_hand);

  const std::string path_, boot_, version_;
  std::map<std::string, int> crashes_;  // By task; does not change once it is made.
  Mutex mutex_;                         // Held while the file is written.
  std::string saved_ ABSL_GUARDED_BY(mutex_);
};

// Leaves out, and tells, work that throws or that ended the server before. For the thread that
// works, but for what says otherwise.
class WorkGuard {
 public:
  // `journal` is CrashJournal's. `on_problem` is told what was left out and why, each piece once.
  WorkGuard(const std::string& journal, const Clock* clock, std::stop_token stop,
            std::function<void(const std::string& problem)> on_problem);

  // Does work that no record may keep from being followed by other work. False where it was not
  // done; nothing is told once `stop` is requested.
  bool Run(const JobKey& key, const std::function<void()>& work);
  // Names the work that is to be tried again, as it was left out for long enough.
  void TryAgain(const std::function<void(const JobKey& key)>& is_due);
  // True the first time that this work is told of.
  bool Tell(const JobKey& key, const std::string& problem);
  void TellAgain(const JobKey& key) { told_.erase(key); }  // Its next problem is news.

  // From any thread: an end of the process from now on has nothing to do with the work at hand.
  void EndTask() { journal_.EndTask(); }
  // Pieces that are left out as servers ended at them; for any thread.
  uint64_t left_out() const { return left_out_; }
  // The work that servers before ended at, left out or not.
  std::vector<JobKey> ended_at() const;

 private:
  bool IsLeftOut(const JobKey& key) const;

  CrashJournal journal_;
  const Clock* const clock_;
  const int64_t started_ns_;
  const std::stop_token stop_;
  const std::function<void(const std::string& problem)> on_problem_;
  std::set<JobKey> told_;
  std::set<JobKey> ended_at_;  // Left out, as the journal says that servers ended at it.
  std::atomic<uint64_t> left_out_ = 0;
};

}  // namespace isthmus::server
