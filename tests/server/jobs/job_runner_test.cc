// The result of a job depends on the job alone, not on the runner or its earlier jobs.
#include "server/jobs/job_runner.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/matching/index/plan_comparison.h"
#include "server/matching/index/session_plan.h"
#include "server/matching/prepared/prepared_submap_codec.h"
#include "storage/memory_store.h"
#include "tests/server/pipeline/robots.h"
#include "tests/storage/faulty_store.h"

namespace isthmus::server {
namespace {

constexpr int kScans = 600;  // Scans of each robot: enough ground in common.

// The maps of two robots of a museum, in a store that outlives the pipeline that made them.
class JobRunnerTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    auto store = storage::MakeFaultyStore(storage::MakeMemoryStore(), faults_);
    store_ = store.get();
    const Drive drive(2, 4);
    PipelineOptions options = QuickOptions();
    options.submap = {};
    options.loops.enabled = false;
    pipeline_ = std::move(Pipeline::Open(options, std::move(store))).value().release();
    for (int robot = 0; robot < 2; ++robot) {
      const SessionId session = Create(*pipeline_, robot == 0 ? kAlice : kBob);
      ASSERT_TRUE(drive.Submit(*pipeline_, session, 0, kScans, robot).ok());
      ASSERT_TRUE(pipeline_->sessions().Finish(session).ok());
    }
    pipeline_->WaitUntilIdle();
  }
  static void TearDownTestSuite() { delete std::exchange(pipeline_, nullptr); }

  static JobMapInput MapOf(const std::string& session) {
    JobMapInput map{.session = SessionId(session)};
    const std::vector<SubmapInfo> submaps = store_->ListSubmaps(map.session).value();
    for (const SubmapInfo& submap : submaps) {
      map.submaps.push_back(submap.id.index);
      map.stamps_ns.push_back(submap.first_stamp_ns);
      map.T_odom_submap.push_back(submap.T_odom_submap);
    }
    return map;
  }
  static PairJob MakeJob() {
    PairJob job{.a = MapOf("alice-1"), .b = MapOf("bob-1")};
    job.search = true;
    job.posted_ns = 77;
    return job;
  }
  // But for times.
  static std::string Run(JobRunner& runner, const PairJob& job) {
    absl::StatusOr<PairResult> result = runner.Run(job, {});
    if (!result.ok()) return std::string(result.status().message());
    for (StageTime& stage : result->match.stages) stage.ms = 0;
    return EncodeResult(*result);
  }

  static inline const auto faults_ = std::make_shared<storage::Faults>();
  static inline storage::MapStore* store_ = nullptr;
  static inline Pipeline* pipeline_ = nullptr;
};

TEST_F(JobRunnerTest, FindsWhatTheServerItselfFinds) {
  JobRunner runner(store_, {});
  const absl::StatusOr<PairResult> result = runner.Run(MakeJob(), {});
  ASSERT_TRUE(result.ok()) << result.status();
  const Match* match = &result->match;
  const Match own = store_->ListMatches()->at(0);
  ASSERT_EQ(own.state, MatchState::kAccepted) << own.detail;
  EXPECT_EQ(match->state, own.state) << match->detail;
  const Pose error = own.T_a_b.Inverse() * match->T_a_b;
  EXPECT_LT(error.translation().norm(), 0.05);
  EXPECT_LT(RotationAngle(error), 0.01);
  EXPECT_EQ(match->computed_ns, 77);
  EXPECT_EQ(match->submaps_a, MakeJob().a.submaps.size());
}

TEST_F(JobRunnerTest, WhatAJobRemembersTheNextGoesOnFromWhoeverRunsIt) {
  JobRunner here(store_, {}), elsewhere(store_, {});
  PairJob job = MakeJob();
  const auto first_submaps = [&](JobMapInput map, size_t count) {
    map.submaps.resize(count);
    map.stamps_ns.resize(count);
    map.T_odom_submap.resize(count);
    return map;
  };
  const size_t count = job.a.submaps.size();
  job.a = first_submaps(job.a, count - 1);
  job.search = false;
  const absl::StatusOr<PairResult> first = here.Run(job, {});
  ASSERT_TRUE(first.ok()) << first.status();
  ASSERT_FALSE(first->memory->hypotheses.empty());
  job.a = MakeJob().a;
  job.memory = first->memory;
  const absl::StatusOr<PairResult> second = here.Run(job, {});
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_EQ(second->match.stages.front().stage, "extend") << "nothing is searched again";
  EXPECT_EQ(second->memory->a.submaps.size(), count);
  const auto sent = std::get<PairJob>(DecodeJob(EncodeJob(job)).value());
  EXPECT_EQ(Run(elsewhere, sent), Run(here, job));
}

TEST_F(JobRunnerTest, TheSameJobGivesTheSameBitsAfterAnything) {
  JobRunner fresh(store_, {}), used(store_, {});
  PairJob part = MakeJob();
  part.a.submaps.resize(2);
  part.a.stamps_ns.resize(2);
  part.a.T_odom_submap.resize(2);
  (void)Run(used, part);
  PairJob bent = MakeJob();
  bent.b.T_odom_submap.back() = bent.b.T_odom_submap.back() * Pose(Eigen::Vector3d(0.1, 0, 0));
  (void)Run(used, bent);
  const std::string expected = Run(fresh, MakeJob());
  EXPECT_EQ(Run(used, MakeJob()), expected);
  EXPECT_EQ(Run(used, std::get<PairJob>(DecodeJob(EncodeJob(MakeJob())).value())), expected);
  EXPECT_NE(Run(used, bent), expected);
}

// A map that was made ready grows to the same bits.
TEST_F(JobRunnerTest, TheSameBitsOfAMapThatHasGrown) {
  JobRunner follows(store_, {});
  const PairJob whole = MakeJob();
  for (size_t count = 1; count <= whole.a.submaps.size(); ++count) {
    PairJob part = whole;
    part.a.submaps.resize(count);
    part.a.stamps_ns.resize(count);
    part.a.T_odom_submap.resize(count);
    JobRunner fresh(store_, {});
    ASSERT_EQ(Run(follows, part), Run(fresh, part)) << count;
  }
}

TEST_F(JobRunnerTest, TheSameBitsWhoeverHasPreparedTheSubmaps) {
  JobRunner finds(store_, {});
  const std::string expected = Run(finds, MakeJob());
  for (const JobMapInput& map : {MapOf("alice-1"), MapOf("bob-1")}) {
    for (const uint32_t index : map.submaps) {
      ASSERT_TRUE(
          store_->PutFeatures({{map.session, index}, matching::kPreparedSubmapKind, "none"}).ok());
    }
  }
  JobRunner makes(store_, {});
  EXPECT_EQ(Run(makes, MakeJob()), expected);
}

// Nothing comes of a part of the map, and the runner is not spoilt by it.
TEST_F(JobRunnerTest, WhileTheStoreIsAwayTheJobIsInnocent) {
  const PairJob job = MakeJob();
  JobRunner runner(store_, {.submap_cache_bytes = 0});
  for (const bool knows_outlines : {false, true}) {
    faults_->FailReads(absl::FailedPreconditionError("the role may not read it"));
    EXPECT_TRUE(absl::IsUnavailable(runner.Run(job, {}).status())) << knows_outlines;
    EXPECT_TRUE(absl::IsUnavailable(runner.Run(PlanJob{job.a, {}}, {}).status())) << knows_outlines;
    faults_->FailReads(absl::OkStatus());
    JobMapInput gone = job.a;
    gone.submaps.push_back(99);
    gone.stamps_ns.push_back(0);
    gone.T_odom_submap.push_back(Pose());
    // It reads all outlines on the way.
    EXPECT_TRUE(absl::IsFailedPrecondition(runner.Run(PlanJob{gone, {}}, {}).status()));
  }
  JobRunner fresh(store_, {});
  EXPECT_EQ(Run(runner, job), Run(fresh, job));
}

// One that waits for a disk leaves out of a job what that does not give, and has it in the next.
TEST_F(JobRunnerTest, ASubmapThatTheDiskDoesNotGiveIsLeftOutOfTheJob) {
  const PairJob job = MakeJob();
  LoopJob loops;
  loops.session = job.a;
  loops.T_map_submap = job.a.T_odom_submap;
  loops.options.min_path_length_m = 15;
  const PlanJob plans{job.a, {job.b}};
  int waits = 0;
  JobRunner runner(store_, {.submap_cache_bytes = 0,
                            .wait = [&waits](const Stopwatch&) { return ++waits % 2 != 0; }});
  for (JobMapInput gone : {job.a, job.b}) {  // It knows the outlines from then on.
    gone.submaps.push_back(99);
    gone.stamps_ns.push_back(0);
    gone.T_odom_submap.push_back(Pose());
    EXPECT_TRUE(absl::IsFailedPrecondition(runner.Run(PlanJob{gone, {}}, {}).status()));
  }
  EXPECT_FALSE(runner.has_left_out());
  faults_->FailReads(absl::UnavailableError("a bad sector"));
  const auto match = runner.Run(job, {});
  EXPECT_TRUE(runner.has_left_out());
  const auto found = runner.Run(loops, {});
  EXPECT_TRUE(runner.has_left_out());
  const auto scores = runner.Run(plans, {});
  faults_->FailReads(absl::OkStatus());
  ASSERT_TRUE(match.ok() && found.ok() && scores.ok()) << match.status() << found.status();
  EXPECT_NE(match->match.state, MatchState::kAccepted);
  EXPECT_TRUE(found->found.empty());
  EXPECT_GT(waits, 0);
  JobRunner fresh(store_, {});
  EXPECT_EQ(Run(runner, job), Run(fresh, job));
  EXPECT_FALSE(runner.has_left_out());
  EXPECT_EQ(EncodeResult(*runner.Run(loops, {})), EncodeResult(*fresh.Run(loops, {})));
  EXPECT_EQ(*runner.Run(plans, {}), *fresh.Run(plans, {}));
}

// As the server compares them itself, after any other job.
TEST_F(JobRunnerTest, ComparesPlansAsTheServerDoes) {
  SubmapCache cache(store_, size_t{64} << 20, [](const SubmapId&, const std::string&) {});
  const PreparedStore prepared(store_, &cache);
  const auto plan_of = [&](const JobMapInput& map) {
    matching::PreparedSubmaps submaps;
    for (const uint32_t index : map.submaps) {
      submaps.push_back(prepared.Get(cache.Outline({map.session, index}), {}).value());
    }
    return std::make_shared<const matching::SessionPlan>(matching::MakeSessionPlan(submaps));
  };
  const JobMapInput a = MapOf("alice-1"), b = MapOf("bob-1");
  const double expected = matching::PlanComparer(plan_of(a)).Score(*plan_of(b));
  ASSERT_GT(expected, 0);
  JobRunner runner(store_, {});
  JobMapInput gone = b;
  gone.submaps.back() = 99;
  EXPECT_EQ(runner.Run(PlanJob{a, {gone, b}}, {}).value(),
            (PlanScores{{b.session}, {b.session, expected}}));
  JobMapInput part = b;
  part.submaps.resize(1);
  part.stamps_ns.resize(1);
  part.T_odom_submap.resize(1);
  EXPECT_NE(runner.Run(PlanJob{a, {part}}, {}).value(), (PlanScores{{b.session, expected}}));
  JobMapInput bent = b;
  bent.T_odom_submap.back() = bent.T_odom_submap.back() * Pose(Eigen::Vector3d(20, 0, 0));
  EXPECT_NE(runner.Run(PlanJob{a, {bent}}, {}).value(), (PlanScores{{b.session, expected}}));
  const std::string bytes = runner.Run(EncodeJob(PlanJob{a, {b}}), {}).value();
  EXPECT_EQ(std::get<PlanScores>(DecodeResult(IndexKey{}, bytes).value()),
            (PlanScores{{b.session, expected}}));
  EXPECT_TRUE(absl::IsFailedPrecondition(runner.Run(PlanJob{gone, {a}}, {}).status()));
}

// The result does not depend on which submaps a runner had, or whether it knows the session.
TEST_F(JobRunnerTest, SearchesForLoopsAsOneFinderDoes) {
  const JobMapInput map = MapOf("alice-1");
  SubmapCache cache(store_, size_t{64} << 20, [](const SubmapId&, const std::string&) {});
  const PreparedStore prepared(store_, &cache);
  matching::LoopOptions options;
  options.min_path_length_m = 15;
  matching::LoopFinder finder(
      options, [&](const auto& outline) { return prepared.Get(outline, {}).value(); },
      [&](const SubmapId& id) { return cache.Get(id); });
  JobRunner runners[] = {JobRunner(store_, {}), JobRunner(store_, {})};
  LoopJob job;
  job.session.session = map.session;
  job.options = options;
  matching::LoopQuery query;
  query.session = map.session;
  for (size_t k = 0; k < map.submaps.size(); ++k) {
    query.first_new = job.first_new = k;
    query.submaps.push_back(cache.Outline({map.session, map.submaps[k]}));
    query.T_map_submap.push_back(map.T_odom_submap[k]);
    job.session = MakeJobMapInput(map.session, query.submaps);
    job.T_map_submap = query.T_map_submap;
    const LoopResult expected{finder.Find(query), finder.memory()};
    const auto found = runners[k % 3 == 0].Run(EncodeJob(job), {});
    ASSERT_TRUE(found.ok()) << found.status();
    EXPECT_EQ(*found, EncodeResult(expected)) << k;
    for (const LoopClosure& loop : expected.found) query.known.push_back(loop);
    job.known = query.known;
    job.memory = std::get<LoopResult>(*DecodeResult(LoopKey{}, *found)).memory;
  }
  EXPECT_FALSE(query.known.empty());
}

TEST_F(JobRunnerTest, ASearchForLoopsLeavesOutWhatCannotBeRead) {
  LoopJob job;
  job.session = MapOf("alice-1");
  job.T_map_submap = job.session.T_odom_submap;
  job.first_new = 2;
  job.options.min_path_length_m = 15;
  const auto without = [&job](size_t k) {
    LoopJob rest = job;
    rest.session.submaps.erase(rest.session.submaps.begin() + static_cast<long>(k));
    rest.session.stamps_ns.erase(rest.session.stamps_ns.begin() + static_cast<long>(k));
    rest.session.T_odom_submap.erase(rest.session.T_odom_submap.begin() + static_cast<long>(k));
    rest.T_map_submap.erase(rest.T_map_submap.begin() + static_cast<long>(k));
    rest.first_new -= k < job.first_new ? 1 : 0;
    return rest;
  };
  const auto run = [](storage::MapStore* store, const LoopJob& loops) {
    return EncodeResult(JobRunner(store, {}).Run(loops, {}).value());
  };
  storage::WriteBatch batch;
  batch.sessions = {store_->GetSession(job.session.session).value()};
  for (const uint32_t index : job.session.submaps) {
    batch.submaps.push_back(store_->GetSubmap({job.session.session, index}).value());
  }
  const auto run_with_damaged = [&](size_t k, const LoopJob& loops) {
    const auto faults = std::make_shared<storage::Faults>();
    const auto store = storage::MakeFaultyStore(storage::MakeMemoryStore(), faults);
    EXPECT_TRUE(store->Write(batch).ok());
    faults->Damage({job.session.session, job.session.submaps[k]});
    return run(store.get(), loops);
  };
  const size_t last = job.session.submaps.size() - 1;
  for (const size_t k : {size_t{1}, last - 1}) {
    const std::string expected = run(store_, without(k));
    EXPECT_NE(expected, EncodeResult(LoopResult()));
    EXPECT_EQ(run_with_damaged(k, job), expected) << k;
  }
  LoopJob newest = job;
  newest.first_new = last;
  newest.memory.radii_m = {{7, 3.25}};
  EXPECT_EQ(run_with_damaged(last, newest), EncodeResult(LoopResult{{}, newest.memory}));
  // One that is gone may have been retired meanwhile, but not the newest.
  LoopJob gone = job;
  gone.session.submaps[1] = 99;
  EXPECT_EQ(run(store_, gone), run(store_, without(1)));
  gone.session.submaps.back() = 99;
  EXPECT_TRUE(absl::IsFailedPrecondition(JobRunner(store_, {}).Run(gone, {}).status()));
}

TEST_F(JobRunnerTest, SubmapsThatAreGoneOrOthersAreNoResult) {
  JobRunner runner(store_, {});
  PairJob job = MakeJob();
  job.a.submaps.back() = 99;
  EXPECT_TRUE(absl::IsFailedPrecondition(runner.Run(job, {}).status()));
  // A session that was deleted and came again by the same id.
  job = MakeJob();
  ++job.b.stamps_ns.front();
  EXPECT_TRUE(absl::IsFailedPrecondition(runner.Run(job, {}).status()));
}

TEST_F(JobRunnerTest, StopsWhenItIsTold) {
  JobRunner runner(store_, {});
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(absl::IsCancelled(runner.Run(MakeJob(), stop.get_token()).status()));
  const PlanJob plans{MapOf("alice-1"), {MapOf("bob-1")}};
  EXPECT_TRUE(absl::IsCancelled(runner.Run(plans, stop.get_token()).status()));
  EXPECT_TRUE(runner.Run(MakeJob(), {}).ok());
}

}  // namespace
}  // namespace isthmus::server
