// Jobs and results arrive at a worker and back as they were, or not at all.
#include "server/jobs/job.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>

#include "tests/storage/records.h"

namespace isthmus::server {
namespace {

PairJob MakeJob() {
  PairJob job;
  for (JobMapInput* map : {&job.a, &job.b}) {
    map->session = SessionId(map == &job.a ? "alice-1" : "bob-1");
    map->submaps = {0, 1, 7};
    map->stamps_ns = {17, 18, 1'700'000'000'000'000'001};
    for (int k = 0; k < 3; ++k) {
      map->T_odom_submap.push_back(Pose::FromXyzRpy(k, 0.1, 0.2, 0.01, 0.02, k));
    }
  }
  matching::SessionShape& shape = job.b.shape.emplace();
  shape.best = shape.odometry = job.b.T_odom_submap;
  pose_graph::Edge edge;
  edge.a = 2;
  edge.T_a_b = Pose::FromXyzRpy(1, 2, 3, 0.1, 0.2, 0.3);
  edge.information(1, 2) = edge.information(2, 1) = 0.3;
  edge.may_be_wrong = true;
  edge.weight = 0.25;
  shape.edges = {edge, edge};
  job.anchors = {storage::MakeAnchor("alice-1", 1)};
  job.known = storage::MakeMatch("alice-1", "bob-1");
  job.known->cycle_m = 0.5;
  job.known->cycle_deg = 0.75;
  AskedDrive& asked = job.known->asked.emplace_back();
  asked.by_b = true;
  asked.rival = 1;
  asked.way = {{4, {1, 2, 3}}};
  asked.leaves_own = 5;
  asked.length_m = 12;
  asked.confidence = 0.97;
  job.options.search = matching::SearchMode::kBirdsEye;
  job.options.min_probability = 0.875;
  job.options.first_look = true;
  job.loops.min_path_length_m = 30;
  job.search = true;
  job.posted_ns = 1'700'000'000'000'000'077;
  return job;
}

const JobKey kMatchKey = MatchKey{{SessionId("alice-1"), SessionId("bob-1")}};
const JobKey kIndexKey = IndexKey{SessionId("alice-1")};
const JobKey kLoopKey = LoopKey{{SessionId("alice-1"), 4}};

template <typename Kind>
absl::StatusOr<Kind> Read(const std::string& bytes) {
  const absl::StatusOr<Job> job = DecodeJob(bytes);
  if (!job.ok()) return job.status();
  if (const auto* read = std::get_if<Kind>(&*job)) return *read;
  return absl::InvalidArgumentError("another kind");
}

TEST(JobTest, ArrivesAsItWas) {
  const PairJob job = MakeJob();
  const std::string bytes = EncodeJob(job);
  const absl::StatusOr<PairJob> read = Read<PairJob>(bytes);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(EncodeJob(*read), bytes);  // Bit by bit, as far as it is sent at all: see below.
  EXPECT_EQ(read->b.submaps, job.b.submaps);
  EXPECT_EQ(read->b.stamps_ns, job.b.stamps_ns);
  EXPECT_FALSE(read->a.shape.has_value());
  ASSERT_TRUE(read->b.shape.has_value());
  ASSERT_EQ(read->b.shape->edges.size(), 2u);
  EXPECT_EQ(read->b.shape->edges[1].a, 2);
  EXPECT_EQ(read->b.shape->edges[1].information(2, 1), 0.3);
  EXPECT_TRUE(read->b.shape->edges[1].may_be_wrong);
  EXPECT_EQ(read->b.shape->edges[1].weight, 0.25);
  EXPECT_EQ(read->anchors[0].note, "the corner stone");
  EXPECT_EQ(read->options.search, matching::SearchMode::kBirdsEye);
  EXPECT_EQ(read->options.min_probability, 0.875);
  EXPECT_TRUE(read->options.first_look);
  EXPECT_EQ(read->loops.min_path_length_m, 30);
  EXPECT_TRUE(read->search);
  EXPECT_EQ(read->posted_ns, job.posted_ns);
}

TEST(JobTest, AMatchLosesNoField) {
  const Match match = *MakeJob().known;
  const Match read =
      std::get<PairResult>(DecodeResult(kMatchKey, EncodeResult(PairResult{match, {}})).value())
          .match;
  EXPECT_EQ(read.detail, match.detail);
  EXPECT_EQ(read.state, match.state);
  EXPECT_EQ(read.reason, match.reason);
  EXPECT_EQ(read.confidence, match.confidence);
  EXPECT_EQ(read.cycle_m, 0.5);
  EXPECT_EQ(read.cycle_deg, 0.75);
  EXPECT_EQ(read.matcher, match.matcher);
  EXPECT_EQ(read.computed_ns, match.computed_ns);
  EXPECT_EQ(read.stages[1].stage, "vgicp");
  EXPECT_EQ(read.stages[1].ms, 3.25);
  ASSERT_EQ(read.edges.size(), match.edges.size());
  EXPECT_EQ(read.edges[1].submap_b, match.edges[1].submap_b);
  EXPECT_EQ(read.edges[1].information, match.edges[1].information);
  ASSERT_EQ(read.rivals.size(), 2u);
  EXPECT_EQ(read.rivals[0].reason, MatchReason::kPossibleTwin);
  EXPECT_EQ(read.rivals[0].edges.size(), 1u);
  EXPECT_EQ(read.rivals[1].state, MatchState::kRejected);
  ASSERT_EQ(read.asked.size(), 1u);
  EXPECT_TRUE(read.asked[0].by_b);
  EXPECT_EQ(read.asked[0].rival, 1u);
  EXPECT_EQ(read.asked[0].way.at(0).submap, 4u);
  EXPECT_EQ(read.asked[0].way.at(0).position, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(read.asked[0].leaves_own, 5u);
  EXPECT_EQ(read.asked[0].length_m, 12);
  EXPECT_EQ(read.asked[0].confidence, 0.97);
}

TEST(JobTest, AComparisonOfPlansLosesNothing) {
  const PairJob pair = MakeJob();
  const std::string bytes = EncodeJob(PlanJob{pair.a, {pair.b, pair.a}});
  const PlanJob read = Read<PlanJob>(bytes).value();
  EXPECT_EQ(read.session.stamps_ns, pair.a.stamps_ns);
  ASSERT_EQ(read.others.size(), 2u);
  EXPECT_EQ(EncodeMap(read.others[0]), EncodeMap(pair.b));
  EXPECT_EQ(EncodeJob(read), bytes);
  const PlanScores scores = {
      {SessionId("bob-1"), 0.25}, {SessionId("carol-1")}, {SessionId("d-1"), 0}};
  EXPECT_EQ(std::get<PlanScores>(DecodeResult(kIndexKey, EncodeResult(scores)).value()), scores);
  // Each is what it is.
  EXPECT_FALSE(Read<PairJob>(bytes).ok());
  EXPECT_FALSE(Read<PlanJob>(EncodeJob(pair)).ok());
  EXPECT_FALSE(DecodeResult(kIndexKey, EncodeResult(PairResult{*pair.known, {}})).ok());
}

TEST(JobTest, WhatIsRememberedOfAPairLosesNothingThatIsAddedTo) {
  auto submap = std::make_shared<Submap>();
  submap->id = {SessionId("alice-1"), 7};
  submap->first_stamp_ns = 70;
  submap->T_odom_submap = Pose(Eigen::Vector3d(1, 2, 3));
  PairJob job = MakeJob();
  const auto kept = std::make_shared<matching::PairMemory>();
  job.memory = kept;
  matching::PairMemory& memory = *kept;
  memory.a = {SessionId("alice-1"), {submap}, {}};
  memory.b = {SessionId("bob-1"), {submap, submap}, {}};
  memory.accepted = memory.lacks_ground = true;
  memory.searched = 5;
  memory.come = 6;
  memory.searched_guess = Pose(Eigen::Vector3d(4, 5, 6));
  matching::Hypothesis& h = memory.hypotheses.emplace_back();
  h.source = GuessSource::kPlaces;
  h.outdoors = h.converged = h.upside_down = true;
  h.moving_is_b = h.can_be_refuted = false;
  h.free_space = {.agree = 1, .front = 2, .regions = 3, .contradicted_regions = 4};
  h.repetition = 0.25;
  h.shared_area_m2 = 60;
  h.shared_share = 0.5;
  h.shared_center = Eigen::Vector3d(7, 8, 9);
  h.joint.poses = {{Pose()}, {Pose(), Pose(Eigen::Vector3d(0, 0, 1))}};
  h.joint.edges = {{0, 1, Pose(Eigen::Vector3d(0, 1, 0)), Matrix6d::Identity()}};
  h.joint.ties = {{0, 0, Pose(Eigen::Vector3d(0, 0, 2)), Matrix6d::Identity()}};
  h.meetings = {.asked_a = 1, .asked_b = 2, .in_vain = {{0, 1}}};
  h.agreement.resize(1);
  h.agreement[0].asked = 9;
  h.agreement[0].on_distinctive = 8;
  h.agreement[0].scatter(2, 3) = 0.125;
  h.things_a = {{11, 12}};
  h.things_b = {{13, 14}, {15, 16}};
  const absl::StatusOr<PairJob> read = Read<PairJob>(EncodeJob(job));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(EncodeJob(*read), EncodeJob(job));
  ASSERT_NE(read->memory, nullptr);
  EXPECT_EQ(read->memory->a.submaps.at(0)->id, submap->id);
  EXPECT_EQ(read->memory->a.submaps.at(0)->first_stamp_ns, 70);
  EXPECT_EQ(read->memory->b.submaps.size(), 2u);
  EXPECT_TRUE(read->memory->accepted && read->memory->lacks_ground);
  EXPECT_EQ(read->memory->searched, 5u);
  EXPECT_EQ(read->memory->come, 6u);
  EXPECT_TRUE(read->memory->searched_guess.has_value());
  const matching::Hypothesis& same = read->memory->hypotheses.at(0);
  EXPECT_EQ(same.source, h.source);
  EXPECT_TRUE(same.outdoors && same.converged && same.upside_down);
  EXPECT_FALSE(same.moving_is_b || same.can_be_refuted);
  EXPECT_EQ(same.free_space.contradicted_regions, 4);
  EXPECT_EQ(same.repetition, 0.25);
  EXPECT_EQ(same.shared_area_m2, 60);
  EXPECT_EQ(same.shared_share, 0.5);
  EXPECT_EQ(same.shared_center.z(), 9);
  EXPECT_EQ(same.joint.poses.b.at(1).translation().z(), 1);
  EXPECT_EQ(same.joint.edges.at(0).submap_b, 1u);
  EXPECT_EQ(same.joint.ties.at(0).T_a_b.translation().z(), 2);
  EXPECT_EQ(same.meetings.asked_b, 2u);
  EXPECT_EQ(same.meetings.in_vain.at(0).b, 1u);
  EXPECT_EQ(same.agreement.at(0).on_distinctive, 8);
  EXPECT_EQ(same.agreement.at(0).scatter(2, 3), 0.125);
  EXPECT_EQ(same.things_b.at(1).gone, 16);
  const auto refused_with = [&](uint32_t& position) {
    const uint32_t before = std::exchange(position, 2);
    EXPECT_FALSE(Read<PairJob>(EncodeJob(job)).ok()) << "of a submap that is not there";
    position = before;
  };
  refused_with(h.joint.edges[0].submap_b);
  refused_with(h.joint.ties[0].submap_b);
  refused_with(h.meetings.in_vain[0].b);
}

TEST(JobTest, ASearchForLoopsLosesNothing) {
  LoopJob job;
  job.session = MakeJob().a;
  job.T_map_submap = job.session.T_odom_submap;
  job.first_new = 2;
  job.known = {storage::MakeLoop(7, "alice-1")};
  job.known[0].rejected = true;
  job.known[0].note = "a mirror";
  job.memory = {{{1.5, 60.25}}, {{0, 12.5}, {7, 3.25}}};
  job.options.max_free_space_outdoors = 0.09;
  job.options.drift.rotation_per_rad = 0.5;
  job.options.prepared_submaps = 17;
  const std::string bytes = EncodeJob(job);
  const LoopJob read = Read<LoopJob>(bytes).value();
  EXPECT_EQ(EncodeJob(read), bytes);
  EXPECT_EQ(read.first_new, 2u);
  EXPECT_EQ(read.options, job.options);
  EXPECT_EQ(read.memory.radii_m, job.memory.radii_m);
  EXPECT_EQ(read.memory.failures[0].new_path_length, 60.25);
  const LoopResult result = std::get<LoopResult>(
      DecodeResult(kLoopKey, EncodeResult(LoopResult{job.known, job.memory})).value());
  EXPECT_EQ(result.memory.radii_m, job.memory.radii_m);
  EXPECT_EQ(result.found[0].detail, job.known[0].detail);
  EXPECT_EQ(result.found[0].edges[0].information, job.known[0].edges[0].information);
  EXPECT_EQ(result.found[0].source, job.known[0].source);
  EXPECT_EQ(result.found[0].note, "a mirror");
  EXPECT_TRUE(result.found[0].rejected);
  // Each is what it is.
  EXPECT_FALSE(Read<PairJob>(bytes).ok());
  EXPECT_FALSE(DecodeResult(kLoopKey, bytes).ok());
  // None is new, or poses are missing.
  job.first_new = 3;
  EXPECT_FALSE(Read<LoopJob>(EncodeJob(job)).ok());
  job.first_new = 0;
  job.T_map_submap.pop_back();
  EXPECT_FALSE(Read<LoopJob>(EncodeJob(job)).ok());
}

TEST(JobTest, WhatIsCutOffOrDamagedIsRefused) {
  const std::string bytes = EncodeJob(MakeJob());
  for (size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_FALSE(Read<PairJob>(bytes.substr(0, size)).ok()) << size;
  }
  for (size_t at = 0; at < bytes.size(); ++at) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    ASSERT_FALSE(Read<PairJob>(damaged).ok()) << at;
  }
  EXPECT_FALSE(Read<PairJob>(bytes + "x").ok());
  EXPECT_FALSE(DecodeResult(kMatchKey, bytes).ok());
}

TEST(JobTest, AMapWhosePartsDoNotFitIsRefused) {
  PairJob job = MakeJob();
  job.a.T_odom_submap.pop_back();
  EXPECT_FALSE(Read<PairJob>(EncodeJob(job)).ok());
  EXPECT_FALSE(Read<PlanJob>(EncodeJob(PlanJob{job.b, {job.b, job.a}})).ok());
  job = MakeJob();
  job.b.shape->edges[0].b = 3;
  EXPECT_FALSE(Read<PairJob>(EncodeJob(job)).ok());
}

}  // namespace
}  // namespace isthmus::server
