#include "server/jobs/job_runner.h"

#include <algorithm>
#include <utility>

#include "core/stopwatch.h"
#include "server/jobs/limits.h"
#include "server/matching/asking/asked_drives.h"
#include "server/matching/index/limits.h"
#include "server/matching/index/plan_comparison.h"
#include "server/matching/loops/meetings.h"

namespace isthmus::server {
namespace {

absl::Status SubmapsAreMissing() {
  return absl::FailedPreconditionError("submaps of it are not there, or damaged");
}

// One submap of a JobMapInput: index, stamp and pose.
constexpr size_t kBytesPerSubmap = sizeof(uint32_t) + sizeof(int64_t) + sizeof(Pose);  // Layout.

// Both have the same submaps, which lie the same. Shapes are not looked at.
bool AreSame(const JobMapInput& a, const JobMapInput& b) {
  return a.submaps == b.submaps && a.stamps_ns == b.stamps_ns &&
         std::ranges::equal(a.T_odom_submap, b.T_odom_submap, [](const Pose& x, const Pose& y) {
           return x.rotation().coeffs() == y.rotation().coeffs() &&
                  x.translation() == y.translation();
         });
}

// Lets a matcher that begins anew try what is known of the pair: a rival may be what others
// settled.
void SuggestKnown(const Match& known, matching::PairMatcher* matcher) {
  const bool accepted = known.state == MatchState::kAccepted;
  if (accepted || !known.edges.empty()) matcher->Suggest(known);
  for (const RivalMatch& rival : known.rivals) {
    if (accepted || rival.edges.empty()) continue;
    Match guess;
    guess.T_a_b = rival.T_a_b;
    guess.matcher = rival.matcher;
    guess.edges = rival.edges;
    matcher->Suggest(guess);
  }
}

}  // namespace

JobRunner::JobRunner(storage::MapStore* store, const Options& options)
    : wait_(options.wait),
      own_submaps_(options.submaps != nullptr
                       ? nullptr
                       : std::make_unique<SubmapCache>(store, options.submap_cache_bytes,
                                                       [](const SubmapId&, const std::string&) {})),
      submaps_(own_submaps_ ? own_submaps_.get() : options.submaps),
      prepared_store_(store, submaps_),
      prepared_([this](const auto& outline) { return GetPrepared(outline); },
                options.prepared_bytes) {}

template <typename Read>
auto JobRunner::Await(const Read& read) -> decltype(read()) {
  static const WaitForStore kAtOnce;
  auto result = AwaitStore(read, has_left_out_ ? kAtOnce : wait_, stop_);
  if (!absl::IsUnavailable(result.status())) return result;
  if (wait_ == nullptr) throw StoreFailed{result.status()};
  has_left_out_ = true;
  return result;
}

std::shared_ptr<const matching::PreparedSubmap> JobRunner::GetPrepared(
    const std::shared_ptr<const Submap>& outline) {
  if (stop_.stop_requested()) throw Stopped();
  const auto prepared = Await([&] { return prepared_store_.Get(outline, stop_); });
  if (prepared.ok()) return *prepared;
  if (!absl::IsUnavailable(prepared.status())) throw StoreFailed{prepared.status()};
  return std::make_shared<const matching::PreparedSubmap>(outline);
}

std::shared_ptr<const Submap> JobRunner::PointsOf(const SubmapId& id) {
  return Await([&] { return submaps_->TryGet(id); }).value_or(nullptr);
}

absl::StatusOr<std::shared_ptr<const Submap>> JobRunner::OutlineOf(const JobMapInput& map,
                                                                   size_t k) {
  const SubmapId id{map.session, map.submaps[k]};
  auto outline = Await([&] { return submaps_->TryOutline(id); });
  if (outline.ok() && (*outline)->first_stamp_ns != map.stamps_ns[k]) {
    submaps_->Forget(id);
    outline = Await([&] { return submaps_->TryOutline(id); });
  }
  const absl::Status& status = outline.status();
  if (absl::IsNotFound(status) || absl::IsDataLoss(status) || absl::IsUnavailable(status)) {
    return status;
  }
  if (!status.ok()) throw StoreFailed{status};
  if ((*outline)->first_stamp_ns != map.stamps_ns[k]) return absl::NotFoundError("another one");
  return matching::LyingAt(*outline, map.T_odom_submap[k]);
}

std::shared_ptr<const JobRunner::Kept> JobRunner::MapOf(const JobMapInput& map) {
  std::string bytes = EncodeMap(map);
  if (const auto* kept = maps_.Use(map.session); kept != nullptr && (*kept)->bytes == bytes) {
    return *kept;
  }
  auto kept = std::make_shared<Kept>();
  kept->bytes = std::move(bytes);
  kept->map.map.session = map.session;
  kept->map.map.points = [this](const SubmapId& id) { return PointsOf(id); };
  for (size_t k = 0; k < map.submaps.size(); ++k) {
    auto outline = OutlineOf(map, k);
    if (!outline.ok()) return nullptr;
    kept->map.map.submaps.push_back(*std::move(outline));
  }
  if (map.shape) kept->map.shape = std::make_shared<const matching::SessionShape>(*map.shape);
  maps_.Put(map.session, kept);
  while (maps_.size() > kMaxPreparedMaps) maps_.DropOldest();
  return kept;
}

template <typename T, typename Work>
absl::StatusOr<T> JobRunner::Guard(const Work& work) {
  if (std::exchange(has_left_out_, false)) {
    // The store may give it by now.
    ForgetIf([](const SessionId&) { return true; });
  }
  try {
    return work();
  } catch (const Stopped&) {
    return absl::CancelledError("stopped");
  } catch (const StoreFailed& failed) {
    return absl::UnavailableError(failed.status.message());
  }
}

absl::StatusOr<PairResult> JobRunner::Run(const PairJob& job, std::stop_token stop) {
  stop_ = stop;
  return Guard<PairResult>([&]() -> absl::StatusOr<PairResult> {
    const auto a = MapOf(job.a), b = MapOf(job.b);
    if (a == nullptr || b == nullptr) return SubmapsAreMissing();
    matching::MatcherOptions options = job.options;
    options.stop = stop;
    matching::PairMatcher matcher(options, job.memory ? *job.memory : matching::PairMemory());
    if (job.known) SuggestKnown(*job.known, &matcher);
    matcher.SetAnchors(job.anchors);
    const auto map_a = prepared_.Get(a->map), map_b = prepared_.Get(b->map);
    Match match = matcher.Update(*map_a, *map_b, job.search);
    if (const auto* joined = matcher.joined(); joined != nullptr && job.loops.enabled) {
      matcher.Tie(*map_a, *map_b, matching::FindMeetings(*map_a, *map_b, *joined, job.loops, stop),
                  &match);
    }
    if (match.state != MatchState::kAccepted) {
      Stopwatch watch;
      match.asked = matching::AskForDrives(*map_a, *map_b, matcher.hypotheses(), options);
      match.stages.push_back({"ask", watch.Lap()});
    }
    if (stop_.stop_requested()) throw Stopped();
    match.computed_ns = job.posted_ns;
    return PairResult{std::move(match),
                      std::make_shared<const matching::PairMemory>(matcher.TakeMemory())};
  });
}

std::shared_ptr<const JobRunner::KeptPlan> JobRunner::PlanOf(const JobMapInput& map) {
  if (const auto* kept = plans_.Use(map.session); kept != nullptr && AreSame((*kept)->map, map)) {
    return *kept;
  }
  matching::PreparedSubmaps submaps;
  for (size_t k = 0; k < map.submaps.size(); ++k) {
    const auto outline = OutlineOf(map, k);
    if (!outline.ok()) return nullptr;
    submaps.push_back(GetPrepared(*outline));
  }
  auto kept = std::make_shared<KeptPlan>();
  kept->map = map;
  kept->plan = std::make_shared<const matching::SessionPlan>(matching::MakeSessionPlan(submaps));
  plans_.Put(map.session, kept, map.submaps.size() * kBytesPerSubmap + kept->plan->bytes());
  while (plans_.size() > 1 && plans_.weight() > matching::kMaxPlanBytes) plans_.DropOldest();
  return kept;
}

absl::StatusOr<PlanScores> JobRunner::Run(const PlanJob& job, std::stop_token stop) {
  stop_ = stop;
  return Guard<PlanScores>([&]() -> absl::StatusOr<PlanScores> {
    const auto plan = PlanOf(job.session);
    if (plan == nullptr) return SubmapsAreMissing();
    matching::PlanComparer comparer(plan->plan);
    PlanScores scores;
    for (const JobMapInput& other : job.others) {
      const auto other_plan = PlanOf(other);
      PlanScore& plan_score = scores.emplace_back(PlanScore{other.session});
      if (other_plan == nullptr) continue;
      plan_score.score = comparer.Score(*other_plan->plan, stop);
      if (stop.stop_requested()) throw Stopped();
    }
    return scores;
  });
}

matching::LoopFinder& JobRunner::FinderOf(const LoopJob& job) {
  const SessionId& session = job.session.session;
  const auto* known = finders_.Use(session);
  std::shared_ptr<KeptFinder> kept = known == nullptr ? nullptr : *known;
  if (kept == nullptr) kept = std::make_shared<KeptFinder>();
  bool knows_others = kept->finder == nullptr || kept->options != job.options;
  for (size_t k = 0; k < job.session.submaps.size(); ++k) {
    int64_t& stamp_ns =
        kept->stamps_ns.try_emplace(job.session.submaps[k], job.session.stamps_ns[k]).first->second;
    knows_others |= std::exchange(stamp_ns, job.session.stamps_ns[k]) != job.session.stamps_ns[k];
  }
  if (knows_others) {
    kept->options = job.options;
    kept->finder = std::make_unique<matching::LoopFinder>(
        job.options, [this](const auto& outline) { return GetPrepared(outline); },
        [this](const SubmapId& id) { return PointsOf(id); });
  }
  finders_.Put(session, kept);
  while (finders_.size() > kMaxKeptFinders) finders_.DropOldest();
  return *kept->finder;
}

absl::StatusOr<LoopResult> JobRunner::Run(const LoopJob& job, std::stop_token stop) {
  stop_ = stop;
  return Guard<LoopResult>([&]() -> absl::StatusOr<LoopResult> {
    matching::LoopQuery query;
    query.session = job.session.session;
    for (size_t k = 0; k < job.session.submaps.size(); ++k) {
      auto outline = OutlineOf(job.session, k);
      const bool is_new = k >= job.first_new;
      if (is_new && absl::IsNotFound(outline.status())) return SubmapsAreMissing();
      if (!outline.ok()) continue;
      if (!is_new) ++query.first_new;
      query.submaps.push_back(*std::move(outline));
      query.T_map_submap.push_back(job.T_map_submap[k]);
    }
    if (query.first_new == query.submaps.size()) return LoopResult{{}, job.memory};
    query.known = job.known;
    matching::LoopFinder& finder = FinderOf(job);
    finder.SetMemory(job.memory);
    LoopResult result;
    result.found = finder.Find(query);
    result.memory = finder.memory();
    return result;
  });
}

absl::StatusOr<JobResult> JobRunner::Run(const Job& job, std::stop_token stop) {
  return std::visit([&](const auto& made) -> absl::StatusOr<JobResult> { return Run(made, stop); },
                    job);
}

absl::StatusOr<std::string> JobRunner::Run(const std::string& bytes, std::stop_token stop) {
  const absl::StatusOr<Job> job = DecodeJob(bytes);
  if (!job.ok()) return job.status();
  const absl::StatusOr<JobResult> result = Run(*job, std::move(stop));
  if (!result.ok()) return result.status();
  return EncodeResult(*result);
}

}  // namespace isthmus::server
