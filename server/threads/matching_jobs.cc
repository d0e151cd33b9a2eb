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

// Of trouble that passes.
bool IsForNow(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsResourceExhausted(status);
}

}  // namespace

std::string MatchingThread::TaskOf(const SessionPair& pair) {
  return absl::StrCat("the match of ", pair.first.value(), " and ", pair.second.value());
}

void MatchingThread::PostMatch(const ShapedMap& a, const ShapedMap& b, std::vector<Anchor> anchors,
                               const Occasion& occasion, const Match* older) {
  const SessionPair pair(a.map.session, b.map.session);
  PairJob job{.a = JobMapOf(a), .b = JobMapOf(b), .anchors = std::move(anchors)};
  if (older != nullptr) job.known = *older;
  job.options = options_.matcher;
  job.search = MustSearch(occasion, older);
  job.posted_ns = clock_->NowNs();
  matchers_.erase(pair);  // Of when there were no workers.
  Post(TaskOf(pair), EncodePairJob(job), PostedMatch{pair, occasion});
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
  Post(IndexTaskOf(session.record.id), EncodePlanJob(job), std::move(posted));
}

void MatchingThread::Post(const std::string& task, std::string payload, Posted posted) {
  const absl::Status status = board_->Post({task, std::move(payload)});
  if (status.ok()) {
    set_aside_.erase(task);
    posted_.insert_or_assign(task, std::move(posted));
  } else if (absl::IsFailedPrecondition(status)) {
    SetAside(task, std::string(status.message()), std::move(posted));
  } else {
    Forget(posted);
    has_workers_ = false;  // Until they are looked for again.
  }
}

void MatchingThread::SetAside(const std::string& task, const std::string& problem, Posted posted) {
  (void)TellLeftOut(task, problem);
  set_aside_.insert_or_assign(task, std::move(posted));
}

void MatchingThread::Forget(const Posted& posted) {
  if (const auto* match = std::get_if<PostedMatch>(&posted)) {
    attempts_.erase(match->pair);
  } else {
    indexed_.erase(std::get<PostedPlans>(posted).session);
  }
}

void MatchingThread::AdoptJobs(const MapView& view) {
  if (board_ == nullptr) return;
  const auto open = board_->ListOpen();
  if (!open.ok()) return;  // What is posted anew takes their places.
  for (const storage::PostedJob& posted : *open) {
    const absl::StatusOr<PairJob> job = DecodePairJob(posted.payload);
    if (!job.ok()) continue;  // Sessions are all compared anew.
    const SessionPair pair(job->a.session, job->b.session);
    const SessionView *a = view.Find(pair.first), *b = view.Find(pair.second);
    if (a == nullptr || b == nullptr) continue;
    attempts_[pair] = AttemptOf(view, *a, *b, static_cast<uint32_t>(job->a.submaps.size()),
                                static_cast<uint32_t>(job->b.submaps.size()), job->posted_ns);
    posted_[posted.key] = PostedMatch{pair, {}};
  }
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
  }
  if (is_due(looked_for_workers_, kLookForWorkersMs)) {
    looked_for_workers_.emplace();
    CountWorkers();
    ForgetMissing();
  }
  posted_count_ = posted_.size();
  set_aside_count_ = set_aside_.size();
}

void MatchingThread::CountWorkers() {
  const absl::StatusOr<storage::WorkerCount> count = board_->CountWorkers();
  if (!count.ok()) return;
  workers_ = static_cast<uint64_t>(count->able);
  has_workers_ = workers_ > 0;
  if (!has_workers_ && !posted_.empty()) WithdrawJobs();
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
  for (auto* jobs : {&posted_, &set_aside_}) {
    std::erase_if(*jobs, [&](const auto& job) {
      if (keys->contains(job.first)) return false;
      Forget(job.second);
      left_out_.erase(job.first);       // What comes of it now is news.
      up_to_date_with_ = ~uint64_t{0};  // Without a change of the map.
      return true;
    });
  }
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
  const auto* match = posted != nullptr ? std::get_if<PostedMatch>(posted) : nullptr;
  const auto* plans = posted != nullptr ? std::get_if<PostedPlans>(posted) : nullptr;
  const auto is_gone = [&view](const SessionId& session) { return view.Find(session) == nullptr; };
  if (plans != nullptr && is_gone(plans->session)) return absl::OkStatus();
  if (match != nullptr && (is_gone(match->pair.first) || is_gone(match->pair.second))) {
    return absl::OkStatus();
  }
  if (!job.problem.empty()) return absl::InternalError(job.problem);
  if (plans != nullptr) return TakeScores(job, *plans);
  if (posted == nullptr && DecodePlanScores(job.result).ok()) return absl::OkStatus();
  return TakeMatchOf(view, job, match != nullptr ? match->occasion : Occasion());
}

absl::Status MatchingThread::TakeMatchOf(const MapView& view, const storage::EndedJob& job,
                                         const Occasion& occasion) {
  const absl::StatusOr<Match> match = DecodeMatch(job.result);
  if (!match.ok()) return match.status();
  const SessionPair pair(match->a, match->b);
  const SessionView *a = view.Find(pair.first), *b = view.Find(pair.second);
  if (a == nullptr || b == nullptr) return absl::OkStatus();  // Deleted meanwhile.
  if (!IsPosted(pair)) {                                      // By an earlier server.
    attempts_[pair] =
        AttemptOf(view, *a, *b, match->submaps_a, match->submaps_b, match->computed_ns);
  }
  return TakeMatch(*match, view.matches.Get(pair).get(), occasion);
}

absl::Status MatchingThread::TakeScores(const storage::EndedJob& job, const PostedPlans& posted) {
  const absl::StatusOr<PlanScores> scores = DecodePlanScores(job.result);
  if (!scores.ok()) return scores.status();
  if (scores->size() != posted.others.size()) return absl::InternalError("of other sessions");
  for (size_t i = 0; i < scores->size(); ++i) {
    const std::optional<double>& score = (*scores)[i];
    if (score && std::isfinite(*score)) index_.Put(posted.session, posted.others[i], *score);
  }
  ChoosePartners(posted.session);
  return absl::OkStatus();
}

void MatchingThread::WithdrawJobs() {
  if (!board_->Withdraw().ok()) return;
  for (const auto& [task, posted] : posted_) Forget(posted);
  posted_.clear();
  looked_for_results_.reset();  // One may have been finished meanwhile.
}

}  // namespace isthmus::server
