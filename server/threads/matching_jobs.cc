// Jobs: what workers compute, on the board of the store.
#include <absl/strings/str_cat.h>

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "server/jobs/job.h"
#include "server/threads/limits.h"
#include "server/threads/matching_thread.h"

namespace isthmus::server {
namespace {

MapOfJob JobMapOf(const ShapedMap& shaped) {
  MapOfJob map = MakeMapOfJob(shaped.map.session, shaped.map.submaps);
  if (shaped.shape) map.shape = *shaped.shape;
  return map;
}

// The map is of the session as it is there, less what was retired.
bool IsOf(const MapView& view, const MapOfJob& map) {
  const SessionView* session = view.Find(map.session);
  if (session == nullptr) return false;
  bool is_there = false;
  for (size_t k = 0; k < map.submaps.size(); ++k) {
    const SubmapInfo* submap = session->submaps.Find(map.submaps[k]);
    if (submap == nullptr) continue;
    if (submap->first_stamp_ns != map.stamps_ns[k]) return false;
    is_there = true;
  }
  return is_there;
}

// Of trouble that passes.
bool IsForNow(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsResourceExhausted(status);
}

}  // namespace

std::string MatchingThread::LoopTaskOf(const SubmapId& submap) {
  return absl::StrCat("the loops of ", ToString(submap));
}

std::string MatchingThread::TaskOf(const SessionPair& pair) {
  return absl::StrCat("the match of ", pair.first.value(), " and ", pair.second.value());
}

void MatchingThread::PostMatch(const ShapedMap& a, const ShapedMap& b, std::vector<Anchor> anchors,
                               const Occasion& occasion, const Match* older) {
  const SessionPair pair(a.map.session, b.map.session);
  PairJob job{.a = JobMapOf(a), .b = JobMapOf(b), .anchors = std::move(anchors)};
  if (older != nullptr) job.known = *older;
  job.options = options_.matcher;
  job.options.first_look = occasion.first_look;
  job.search = MustSearch(occasion, older);
  job.posted_ns = clock_->NowNs();
  matchers_.erase(pair);  // Of when there were no workers.
  Post({TaskOf(pair), EncodePairJob(job)}, PostedMatch{pair});
}

void MatchingThread::PostPlans(const MapView& view, const SessionView& session,
                               const std::vector<const SessionView*>& others) {
  PlanJob job;
  job.session = MakeMapOfJob(session.record.id, shapes_.Of(view, session).submaps);
  PostedPlans posted{session.record.id, {}};
  for (const SessionView* other : others) {
    job.others.push_back(MakeMapOfJob(other->record.id, shapes_.Of(view, *other).submaps));
    posted.others.push_back(other->record.id);
  }
  Post({IndexTaskOf(session.record.id), EncodePlanJob(job)}, std::move(posted));
}

bool MatchingThread::WantsHelpWithLoops() const {
  const bool are_busy = took_loops_back_ && took_loops_back_->Ms() < kLoopsAtHomeMs;
  return has_workers_ && !are_busy && waiting_submaps_ > kLoopsAtHome &&
         posted_.size() < 2 * kMaxPostedJobs;
}

void MatchingThread::PostLoops(const matching::LoopQuery& query) {
  LoopJob job;
  job.session = MakeMapOfJob(query.session, query.submaps);
  job.T_map_submap = query.T_map_submap;
  job.first_new = query.first_new;
  job.known = query.known;
  job.memory = FinderOf(query.session).memory();
  job.options = options_.loops;
  // The next submap of the session waits for what comes of it.
  const SubmapId submap = query.submaps.back()->id;
  Post({LoopTaskOf(submap), EncodeLoopJob(job), /*is_urgent=*/true}, PostedLoops{submap});
}

void MatchingThread::Post(storage::PostedJob job, Posted posted) {
  const std::string task = job.key;
  const absl::Status status = board_->Post(job);
  if (status.ok()) {
    set_aside_.erase(task);
    posted_.insert_or_assign(task, std::move(posted));
  } else if (absl::IsFailedPrecondition(status)) {
    SetAside(task, std::string(status.message()), std::move(posted));
  } else {
    TellOfBoard("jobs cannot be given to workers", status);
    Forget(posted);
    has_workers_ = false;  // Until they are looked for again.
  }
}

void MatchingThread::TellOfBoard(const std::string& what, const absl::Status& status) {
  const std::string problem = absl::StrCat(what, ": ", status.message());
  if (absl::IsUnavailable(status) || !left_out_.insert(problem).second) return;
  if (options_.on_problem) options_.on_problem(problem);
}

void MatchingThread::SetAside(const std::string& task, const std::string& problem, Posted posted) {
  (void)TellLeftOut(task, problem);
  set_aside_.insert_or_assign(task, std::move(posted));
}

bool MatchingThread::IsSetAside(const std::string& task, Posted job) {
  const auto it = set_aside_.find(task);
  if (it == set_aside_.end()) return false;
  it->second = std::move(job);
  return true;
}

void MatchingThread::Forget(const Posted& posted) {
  if (const auto* match = std::get_if<PostedMatch>(&posted)) {
    attempts_.erase(match->pair);
  } else if (const auto* plans = std::get_if<PostedPlans>(&posted)) {
    indexed_.erase(plans->session);
  } else {
    const SubmapId& submap = std::get<PostedLoops>(posted).submap;
    // Where the session went on without, what came later closes the loop too.
    const auto next = looped_.find(submap.session);
    if (next != looped_.end() && next->second == submap.index + 1) next->second = submap.index;
  }
}

void MatchingThread::AdoptJobs(const MapView& view) {
  if (board_ == nullptr) return;
  const auto jobs = board_->ListAll();
  if (!jobs.ok()) return;  // What is posted anew takes their places.
  for (const storage::BoardJob& job : *jobs) {
    std::optional<Posted> posted = PostedOf(view, job);
    const auto* match = posted ? std::get_if<PostedMatch>(&*posted) : nullptr;
    if (posted && job.is_set_aside) {
      set_aside_.emplace(job.key, *std::move(posted));
      (void)TellLeftOut(job.key,
                        "workers ended while they were at it; see its row in the table jobs");
    } else if (match != nullptr) {
      const absl::StatusOr<PairJob> made = DecodePairJob(job.payload);
      attempts_[match->pair] =
          AttemptOf(view, *view.Find(match->pair.first), *view.Find(match->pair.second),
                    static_cast<uint32_t>(made->a.submaps.size()),
                    static_cast<uint32_t>(made->b.submaps.size()), made->posted_ns);
      posted_[job.key] = *match;
    } else {
      // Sessions are all compared, and submaps searched for loops, anew.
      (void)board_->Drop(job.key);
    }
  }
}

std::optional<MatchingThread::Posted> MatchingThread::PostedOf(const MapView& view,
                                                               const storage::BoardJob& job) {
  const auto with_key = [&job](const std::string& task, Posted posted) {
    return task == job.key ? std::optional<Posted>(std::move(posted)) : std::nullopt;
  };
  if (const auto pair = DecodePairJob(job.payload); pair.ok()) {
    if (!IsOf(view, pair->a) || !IsOf(view, pair->b)) return std::nullopt;
    const SessionPair ids(pair->a.session, pair->b.session);
    return with_key(TaskOf(ids), PostedMatch{ids});
  }
  if (const auto plans = DecodePlanJob(job.payload); plans.ok()) {
    if (!IsOf(view, plans->session)) return std::nullopt;
    return with_key(IndexTaskOf(plans->session.session), PostedPlans{plans->session.session, {}});
  }
  if (const auto loops = DecodeLoopJob(job.payload); loops.ok()) {
    if (!IsOf(view, loops->session)) return std::nullopt;
    const SubmapId submap{loops->session.session, loops->session.submaps.back()};
    return with_key(LoopTaskOf(submap), PostedLoops{submap});
  }
  return std::nullopt;
}

bool MatchingThread::IsGone(const MapView& view, const Posted& posted) {
  const auto is_gone = [&view](const SessionId& session) { return view.Find(session) == nullptr; };
  if (const auto* match = std::get_if<PostedMatch>(&posted)) {
    return is_gone(match->pair.first) || is_gone(match->pair.second);
  }
  const auto* plans = std::get_if<PostedPlans>(&posted);
  return is_gone(plans != nullptr ? plans->session : std::get<PostedLoops>(posted).submap.session);
}

void MatchingThread::FollowWorkers(const MapView& view) {
  if (board_ == nullptr) return;
  const auto is_due = [](const std::optional<Stopwatch>& looked, double every_ms) {
    return !looked || looked->Ms() >= every_ms;
  };
  if (!looked_for_results_ ||
      (!posted_.empty() && is_due(looked_for_results_, kLookForResultsMs))) {
    looked_for_results_.emplace();
    TakeResults(view);
    TakeBackLoops();
  }
  if (is_due(looked_for_workers_, kLookForWorkersMs)) {
    looked_for_workers_.emplace();
    CountWorkers();
    ForgetMissing();
    RemoveGone(view);
  }
  posted_count_ = posted_.size();
  set_aside_count_ = set_aside_.size() + ended_at_.size();
}

void MatchingThread::CountWorkers() {
  const absl::StatusOr<storage::WorkerCount> count = board_->CountWorkers();
  workers_ = count.ok() ? static_cast<uint64_t>(count->able) : 0;
  has_workers_ = workers_ > 0;
  if (!has_workers_ && !posted_.empty()) WithdrawJobs();
  if (!count.ok()) return TellOfBoard("workers cannot be counted", count.status());
  const bool has_others = count->of_other_versions > 0;
  if (has_others && !told_of_other_versions_ && options_.on_problem) {
    options_.on_problem(absl::StrCat(count->of_other_versions,
                                     " workers are of another version than the server and do none "
                                     "of its jobs; start those of its own"));
  }
  told_of_other_versions_ = has_others;
}

void MatchingThread::ForgetMissing() {
  if (posted_.empty() && set_aside_.empty()) return;
  const auto keys = board_->ListKeys();
  if (!keys.ok()) return;
  const auto is_missing = [&](const std::string& task) {
    if (keys->contains(task)) return false;
    left_out_.erase(task);            // What comes of it now is news.
    up_to_date_with_ = ~uint64_t{0};  // Without a change of the map.
    return true;
  };
  std::erase_if(posted_, [&](const auto& job) {
    if (!is_missing(job.first)) return false;
    Forget(job.second);
    return true;
  });
  std::erase_if(set_aside_, [&](const auto& job) {
    if (!is_missing(job.first)) return false;
    if (job.second) Forget(*job.second);
    return true;
  });
}

void MatchingThread::TakeBackLoops() {
  std::erase_if(posted_, [this](const auto& job) {
    const auto* loops = std::get_if<PostedLoops>(&job.second);
    if (loops == nullptr || loops->posted.Ms() < kLoopsUntakenMs) return false;
    const absl::StatusOr<bool> was_nobodys = board_->TakeBack(job.first);
    if (!was_nobodys.ok() || !*was_nobodys) return false;
    took_loops_back_.emplace();
    Forget(job.second);
    return true;
  });
}

void MatchingThread::RemoveGone(const MapView& view) {
  std::erase_if(posted_, [&](const auto& job) {
    return IsGone(view, job.second) && board_->Drop(job.first).ok();
  });
  std::erase_if(set_aside_, [&](const auto& job) {
    return job.second && IsGone(view, *job.second) && board_->Drop(job.first).ok();
  });
}

void MatchingThread::TakeResults(const MapView& view) {
  const auto ended = board_->ListEnded();
  if (!ended.ok()) return;
  std::vector<storage::EndedJob> taken;
  for (const storage::EndedJob& job : *ended) {
    const auto it = posted_.find(job.key);
    const Posted* posted = it == posted_.end() ? nullptr : &it->second;
    const absl::Status status = TakeResult(view, job, posted);
    if (IsForNow(status)) continue;  // It stays on the board.
    const auto* loops = posted != nullptr ? std::get_if<PostedLoops>(posted) : nullptr;
    if (!status.ok() && loops != nullptr) has_gaps_.insert(loops->submap.session);
    if (!status.ok() && job.is_set_aside) {
      if (posted != nullptr) SetAside(job.key, job.problem, *posted);
    } else if (!status.ok()) {
      const bool is_first = TellLeftOut(job.key, std::string(status.message()));
      // Its submaps may have been retired while it waited; a second time it is something else.
      if (is_first && posted != nullptr) Forget(*posted);
    }
    if (posted != nullptr) posted_.erase(it);
    taken.push_back(job);
  }
  // What stays there is taken again, and nothing comes of it.
  (void)board_->Remove(taken);
}

absl::Status MatchingThread::TakeResult(const MapView& view, const storage::EndedJob& job,
                                        const Posted* posted) {
  const auto* plans = posted != nullptr ? std::get_if<PostedPlans>(posted) : nullptr;
  const auto* loops = posted != nullptr ? std::get_if<PostedLoops>(posted) : nullptr;
  if (!job.is_set_aside && posted != nullptr && IsGone(view, *posted)) return absl::OkStatus();
  if (!job.problem.empty()) return absl::InternalError(job.problem);
  if (plans != nullptr) return TakeScores(view, job, *plans);
  if (loops != nullptr) return TakeLoops(job, *loops);
  const bool is_outdated =
      posted == nullptr && (DecodePlanScores(job.result).ok() || DecodeLoopResult(job.result).ok());
  if (is_outdated) return absl::OkStatus();
  return TakeMatchOf(view, job);
}

absl::Status MatchingThread::TakeMatchOf(const MapView& view, const storage::EndedJob& job) {
  const absl::StatusOr<Match> match = DecodeMatch(job.result);
  if (!match.ok()) return match.status();
  const SessionPair pair(match->a, match->b);
  if (TaskOf(pair) != job.key) return absl::InternalError("the result is another pair's");
  const SessionView *a = view.Find(pair.first), *b = view.Find(pair.second);
  if (a == nullptr || b == nullptr) return absl::OkStatus();  // Deleted meanwhile.
  if (!IsPosted(pair)) {                                      // By an earlier server.
    attempts_[pair] =
        AttemptOf(view, *a, *b, match->submaps_a, match->submaps_b, match->computed_ns);
  }
  return TakeMatch(*match, view.matches.Get(pair).get());
}

absl::Status MatchingThread::TakeScores(const MapView& view, const storage::EndedJob& job,
                                        const PostedPlans& posted) {
  const absl::StatusOr<PlanScores> scores = DecodePlanScores(job.result);
  if (!scores.ok()) return scores.status();
  if (scores->size() != posted.others.size()) return absl::InternalError("of other sessions");
  for (size_t i = 0; i < scores->size(); ++i) {
    const std::optional<double>& score = (*scores)[i];
    if (score && std::isfinite(*score)) index_.Put(posted.session, posted.others[i], *score);
  }
  ChoosePartners(view, posted.session);
  return absl::OkStatus();
}

absl::Status MatchingThread::TakeLoops(const storage::EndedJob& job, const PostedLoops& posted) {
  absl::StatusOr<LoopResult> result = DecodeLoopResult(job.result);
  if (!result.ok()) return result.status();
  const SessionId& session = posted.submap.session;
  for (const LoopClosure& loop : result->found) {
    if (loop.session != session) return absl::InternalError("of another session");
  }
  absl::Status status = map_->AddLoops(std::move(result->found));
  if (status.ok()) StoreSearched(posted.submap);
  // After the session's last submap there is none.
  const auto finder = finders_.find(session);
  if (status.ok() && finder != finders_.end()) finder->second.SetMemory(std::move(result->memory));
  return status;
}

void MatchingThread::WithdrawJobs() {
  if (!board_->Withdraw().ok()) return;
  // Those that were set aside, or finished meanwhile, stay: the next look at what has ended tells.
  const auto left = board_->ListKeys();
  if (!left.ok()) return;  // See ForgetMissing.
  std::erase_if(posted_, [&](const auto& job) {
    if (left->contains(job.first)) return false;
    Forget(job.second);
    return true;
  });
  looked_for_results_.reset();
}

}  // namespace isthmus::server
