// The pairs of sessions that are searched: all of a few, the likeliest of many.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "server/jobs/job_key.h"
#include "server/matching/index/limits.h"
#include "server/threads/crash_journal.h"
#include "server/threads/limits.h"
#include "tests/server/pipeline/many_sessions.h"
#include "tests/server/pipeline/robots.h"
#include "tests/storage/records.h"
#include "tests/storage/temporary_folder.h"

namespace isthmus::server {
namespace {

using matching::kLookedPartners;
using matching::kSearchAllSessions;
using matching::kSearchPartners;
using storage::MakeSubmap;

class PartnersTest : public ::testing::Test {
 protected:
  // A session with one submap had its partners chosen: it may try so many pairs.
  static storage::MatchingProgress Chosen(const SessionId& session, uint64_t pairs,
                                          uint64_t searched) {
    return {session, 0, 1, pairs, searched, matching::kNearPartners};
  }
  // `have_partners`: all of them have had the partners that they were allowed.
  void Open(const storage::WriteBatch& batch, bool have_partners = false,
            const PipelineOptions& options = QuickOptions()) {
    auto store = storage::MakeMemoryStore();
    ASSERT_TRUE(store->Write(batch).ok());
    for (const SessionRecord& session : batch.sessions) {
      if (!have_partners) break;
      ASSERT_TRUE(store->Write({.matching_progress = {Chosen(session.id, 0, 0)}}).ok());
    }
    pipeline_ = Pipeline::Open(options, std::move(store)).value();
    pipeline_->WaitUntilIdle();
  }
  std::set<std::pair<SessionId, SessionId>> Searched() const {
    std::set<std::pair<SessionId, SessionId>> pairs;
    for (const MatchEdge& edge : pipeline_->reader().GetMatchGraph().matches) {
      pairs.emplace(edge.match.a, edge.match.b);
    }
    return pairs;
  }

  std::unique_ptr<Pipeline> pipeline_;
};

TEST_F(PartnersTest, AllPairsOfAFew) {
  Open(ManySessions(kSearchAllSessions));
  EXPECT_EQ(Searched().size(), kSearchAllSessions * (kSearchAllSessions - 1) / 2);
}

// In these nothing is to be seen, so a first look is all that they get.
TEST_F(PartnersTest, SomeOfMany) {
  constexpr size_t kCount = 4 * kSearchAllSessions;
  Open(ManySessions(kCount));
  const auto searched = Searched();
  EXPECT_LE(searched.size(), kCount * kLookedPartners);
  std::map<SessionId, size_t> partners;
  for (const auto& [a, b] : searched) {
    ++partners[a];
    ++partners[b];
  }
  for (size_t i = 0; i < kCount; ++i) EXPECT_GE(partners[NameOfMany(i)], kLookedPartners) << i;
  for (const MatchEdge& edge : pipeline_->reader().GetMatchGraph().matches) {
    EXPECT_EQ(edge.match.reason, MatchReason::kNoCandidate);
  }
}

TEST_F(PartnersTest, WhatAnchorsPutSideBySideIsOneOfThem) {
  constexpr size_t kCount = 3 * kSearchAllSessions;
  storage::WriteBatch batch = ManySessions(kCount);
  // Two and two, 10 m apart, of which nothing else says that they are partners.
  const std::vector<size_t> anchored = {kCount - 4, kCount - 3, kCount - 2, kCount - 1};
  for (size_t i = 0; i < anchored.size(); ++i) {
    const double x = i < 2 ? 10.0 * static_cast<double>(i) : 500 + 10.0 * static_cast<double>(i);
    batch.anchors.push_back(
        {{NameOfMany(anchored[i]), 0}, Pose::FromXyzRpy(x, 0, 0, 0, 0, 0), 1, 1, 1, "", 1});
  }
  Open(batch);
  const auto searched = Searched();
  EXPECT_TRUE(searched.contains({NameOfMany(kCount - 4), NameOfMany(kCount - 3)}));
  EXPECT_TRUE(searched.contains({NameOfMany(kCount - 2), NameOfMany(kCount - 1)}));
  EXPECT_FALSE(searched.contains({NameOfMany(kCount - 3), NameOfMany(kCount - 2)}));
}

TEST_F(PartnersTest, WhatIsJoinedIsSearchedWhereItLiesSideBySide) {
  constexpr size_t kCount = 3 * kSearchAllSessions;
  storage::WriteBatch batch = ManySessions(kCount);
  // Three in a row, and a fourth far from them: the plans say nothing of it.
  const size_t first = kCount - 4;
  for (size_t i = 0; i < 3; ++i) {
    Match match;
    match.a = NameOfMany(first + i);
    match.b = NameOfMany(first + i + 1);
    match.T_a_b = Pose::FromXyzRpy(i < 2 ? 10 : 500, 0, 0, 0, 0, 0);
    match.state = MatchState::kAccepted;
    match.confidence = 1;
    match.submaps_a = match.submaps_b = 1;
    match.computed_ns = batch.sessions[0].finished_ns + 1;
    batch.matches.push_back(match);
  }
  Open(batch);
  const auto searched = Searched();
  EXPECT_TRUE(searched.contains({NameOfMany(first), NameOfMany(first + 2)}));
  EXPECT_FALSE(searched.contains({NameOfMany(first), NameOfMany(first + 3)}));
  EXPECT_FALSE(searched.contains({NameOfMany(first + 1), NameOfMany(first + 3)}));
}

TEST_F(PartnersTest, HoweverManyStrangersWereTriedThereIsRoomForWhatLiesBesideIt) {
  constexpr size_t kCount = 2 * kSearchAllSessions, kRow = kCount - 3;
  storage::WriteBatch batch = ManySessions(kCount);
  const auto add = [&](size_t a, size_t b, MatchState state, MatchReason reason) {
    Match match;
    match.a = NameOfMany(a);
    match.b = NameOfMany(b);
    match.T_a_b = Pose::FromXyzRpy(10, 0, 0, 0, 0, 0);
    match.state = state;
    match.reason = reason;
    match.confidence = state == MatchState::kAccepted ? 1 : 0;
    match.submaps_a = match.submaps_b = 1;
    match.computed_ns = batch.sessions[0].finished_ns + 1;
    batch.matches.push_back(match);
  };
  for (size_t stranger = 0; stranger < kSearchAllSessions; ++stranger) {
    for (size_t i = kRow; i < kCount; ++i) {
      add(stranger, i, MatchState::kRejected, MatchReason::kNoCandidate);
    }
  }
  for (size_t i = kRow; i + 1 < kCount; ++i) {
    add(i, i + 1, MatchState::kAccepted, MatchReason::kNone);
  }
  Open(batch, true);
  EXPECT_EQ(Searched().size(), batch.matches.size() + 1);
  EXPECT_TRUE(Searched().contains({NameOfMany(kRow), NameOfMany(kRow + 2)}));
}

// The pairs that were tried in its place have used up the room of both.
TEST_F(PartnersTest, ThePairThatAServerEndedAtIsTriedAgain) {
  constexpr size_t kCount = 2 * kSearchAllSessions;
  const storage::TemporaryFolder folder;
  std::filesystem::create_directories(folder.path());
  PipelineOptions options = QuickOptions();
  options.crash_journal = folder.path() + "/journal";
  const std::pair<SessionId, SessionId> pair(NameOfMany(1), NameOfMany(2));
  CrashJournal(options.crash_journal).BeginTask(ToText(MatchKey{pair}));
  Open(ManySessions(kCount), true, options);
  EXPECT_EQ(Searched(), (std::set<std::pair<SessionId, SessionId>>{pair}));
}

TEST_F(PartnersTest, SegmentsOfASessionArePartners) {
  constexpr size_t kCount = 3 * kSearchAllSessions;
  storage::WriteBatch batch = ManySessions(kCount);
  SessionRecord second = batch.sessions.back();
  second.segment = 2;
  second.first_segment = second.id;
  second.id = SegmentId(second.first_segment, 2);
  batch.sessions.push_back(second);
  batch.submaps.push_back(MakeSubmap(second.id.value(), 0, 200));
  Open(batch);
  EXPECT_TRUE(Searched().contains({second.first_segment, second.id}));
}

// An idle server goes on with what it has found.
TEST_F(PartnersTest, ANewSessionAfterARestartHasPartnersToo) {
  constexpr size_t kCount = 2 * kSearchAllSessions;
  storage::WriteBatch batch = ManySessions(kCount);
  for (size_t i = 0; i < kCount - 1; ++i) {
    for (size_t by = 1; by <= kSearchPartners; ++by) {
      Match match;
      match.a = std::min(NameOfMany(i), NameOfMany((i + by) % (kCount - 1)));
      match.b = std::max(NameOfMany(i), NameOfMany((i + by) % (kCount - 1)));
      match.submaps_a = match.submaps_b = 1;
      match.computed_ns = batch.sessions[0].finished_ns + 1;
      batch.matches.push_back(match);
    }
  }
  Open(batch);
  const auto searched = Searched();
  EXPECT_EQ(searched.size(), batch.matches.size() + kLookedPartners);
  size_t of_new = 0;
  const SessionId last = NameOfMany(kCount - 1);
  for (const auto& [a, b] : searched) of_new += a == last || b == last;
  EXPECT_EQ(of_new, kLookedPartners);  // None was worth more than a look.
}

TEST_F(PartnersTest, AfterARestartASessionGetsWhatItWasDue) {
  constexpr size_t kCount = kSearchAllSessions + 1;
  auto memory = storage::MakeMemoryStore();
  storage::MapStore& store = *memory;
  storage::WriteBatch batch = ManySessions(kCount);
  ASSERT_TRUE(store.Write(batch).ok());
  pipeline_ = Pipeline::Open(QuickOptions(), std::move(memory)).value();
  pipeline_->WaitUntilIdle();
  ASSERT_EQ(Searched().size(), kCount * (kCount - 1) / 2);  // Fewer than twenty each.
  const storage::MatchingProgress chosen = store.ListMatchingProgress().value().front();
  ASSERT_EQ(chosen.session, NameOfMany(0));
  // The server before had tried so many of it when it ended, as if each were worth a search.
  for (const MatchEdge& edge : pipeline_->reader().GetMatchGraph().matches) {
    if (edge.match.a != NameOfMany(0) || batch.matches.size() == kSearchPartners) continue;
    batch.matches.push_back(edge.match);
    batch.matches.back().reason = MatchReason::kNone;
  }
  const auto tried_after_restart = [&](const storage::MatchingProgress& allowed) {
    auto next = storage::MakeMemoryStore();
    EXPECT_TRUE(next->Write(batch).ok());
    EXPECT_TRUE(next->Write({.matching_progress = {allowed}}).ok());
    // Others have had theirs, and bring none to it.
    for (size_t i = 1; i < kCount; ++i) {
      EXPECT_TRUE(next->Write({.matching_progress = {Chosen(NameOfMany(i), 0, 0)}}).ok());
    }
    pipeline_ = Pipeline::Open(QuickOptions(), std::move(next)).value();
    pipeline_->WaitUntilIdle();
    return Searched().size();
  };
  EXPECT_EQ(tried_after_restart(chosen), kSearchPartners);
  EXPECT_EQ(tried_after_restart(Chosen(NameOfMany(0), 30, 10)), kCount - 1);
}

}  // namespace
}  // namespace isthmus::server
