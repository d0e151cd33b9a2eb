#include "lab/bench/merging/wild_pairs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "lab/bench/merging/hypothesis_table.h"

namespace isthmus::bench {
namespace {

using ::testing::HasSubstr;

std::vector<std::string> NamesOf(const std::vector<WildPair>& pairs) {
  std::vector<std::string> names;
  for (const WildPair& pair : pairs) names.push_back(NameOf(pair));
  return names;
}

TEST(DrawWildPairs, HasTeamsStrangersAndTwins) {
  const auto pairs = DrawWildPairs({.worlds = 2, .seed = 5, .kind = "house", .robots = 3});
  ASSERT_TRUE(pairs.ok()) << pairs.status();
  EXPECT_THAT(NamesOf(*pairs),
              ::testing::ElementsAre("house", "house", "house", "house twin", "house", "house",
                                     "house", "house stranger", "house twin"));
  for (const WildPair& pair : *pairs) {
    EXPECT_EQ(pair.a.Ground() == pair.b.Ground(), pair.relation == WildRelation::kTeam);
    EXPECT_NE(pair.a.Key(), pair.b.Key());
  }
  // A wood is not built twice.
  const auto woods = DrawWildPairs({.worlds = 1, .seed = 5, .kind = "forest", .robots = 2});
  EXPECT_THAT(NamesOf(*woods), ::testing::ElementsAre("forest"));
}

TEST(DrawWildPairs, HasFurnishedTwinsOfThreeSorts) {
  const auto pairs = DrawWildPairs({.worlds = 1, .seed = 5, .kind = "flat", .robots = 2});
  ASSERT_TRUE(pairs.ok()) << pairs.status();
  EXPECT_THAT(NamesOf(*pairs),
              ::testing::ElementsAre("flat", "flat twin", "flat exact twin", "flat bare twin"));
  std::vector<std::string> keys;
  for (const WildPair& pair : *pairs) {
    EXPECT_EQ(pair.a.Ground() == pair.b.Ground(), pair.relation == WildRelation::kTeam);
    keys.insert(keys.end(), {pair.a.Key(), pair.b.Key()});
  }
  std::sort(keys.begin(), keys.end());
  // The first robot is the same for the team and for the twin of other furniture.
  EXPECT_EQ(std::unique(keys.begin(), keys.end()) - keys.begin(), 7);
}

TEST(DrawWildPairs, TakesKindsInTurn) {
  const auto pairs = DrawWildPairs({.worlds = 4, .seed = 6, .kind = "forest,mine", .robots = 2});
  EXPECT_THAT(NamesOf(*pairs), ::testing::ElementsAre("forest", "mine", "forest", "forest stranger",
                                                      "mine", "mine stranger"));
}

TEST(DrawWildPairs, WholeOnesAreNotCut) {
  WildPairsOptions options;
  options.worlds = 1;
  EXPECT_LT(DrawWildPairs(options)->front().most_overlap, 1);
  options.whole = true;
  EXPECT_EQ(DrawWildPairs(options)->front().most_overlap, 1);
}

TEST(DrawWildPairs, StrangersAreOfOneKindAndTwoWorlds) {
  WildPairsOptions options;
  options.worlds = 2;
  options.seed = 100;
  options.robots = 2;
  options.strangers = 500;
  const auto pairs = DrawWildPairs(options);
  ASSERT_EQ(pairs->size(), 8u);
  for (const WildPair& pair : *pairs) {
    EXPECT_EQ(pair.relation, WildRelation::kStranger);
    EXPECT_EQ(pair.a.world, pair.b.world);
    EXPECT_LT(pair.a.seed, 102u);
    EXPECT_GE(pair.b.seed, 500u);
  }
}

TEST(DrawWildPairs, FollowFromTheirSeed) {
  const WildPairsOptions options{.worlds = 16, .seed = 40, .robots = 2};
  const auto once = DrawWildPairs(options), again = DrawWildPairs(options);
  ASSERT_EQ(once->size(), again->size());
  for (size_t i = 0; i < once->size(); ++i) {
    EXPECT_EQ((*once)[i].a.Key(), (*again)[i].a.Key());
    EXPECT_EQ((*once)[i].b.Key(), (*again)[i].b.Key());
    EXPECT_EQ((*once)[i].most_overlap, (*again)[i].most_overlap);
  }
  // All kinds in turn.
  std::vector<std::string> kinds;
  for (const WildPair& pair : *once) kinds.push_back(pair.kind);
  std::sort(kinds.begin(), kinds.end());
  kinds.erase(std::unique(kinds.begin(), kinds.end()), kinds.end());
  EXPECT_EQ(kinds.size(), 16u);
}

TEST(DrawWildPairs, SaysWhatIsNotKnown) {
  EXPECT_EQ(DrawWildPairs({.worlds = 1, .kind = "moon"}).status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(WildTable, CountsByWhatPairsHaveInCommon) {
  const auto trial = [](const std::string& scenario, double overlap, TrialOutcome outcome) {
    Trial made;
    made.scenario = scenario;
    made.pairs.resize(1);
    made.pairs[0].overlap = overlap;
    made.pairs[0].outcome = outcome;
    made.pairs[0].map.median_m = 0.04;
    return made;
  };
  const std::string table = WildTable(
      {trial("house", 0.5, TrialOutcome::kRight), trial("house", 0.4, TrialOutcome::kNotMerged),
       trial("house", 0.2, TrialOutcome::kNotMerged), trial("house twin", 0, TrialOutcome::kWrong),
       trial("house stranger", 0, TrialOutcome::kNotMerged)});
  EXPECT_THAT(table,
              HasSubstr("| overlap 0.30 and more | 2 | 1 | 50 % | 0 | 1 | 0 | 0.040 (0.040)"));
  EXPECT_THAT(table, HasSubstr("| overlap 0.15-0.30 | 1 | 0 | 0 % | 0 | 1 | 0 |"));
  EXPECT_THAT(table, HasSubstr("| twins | 1 | 0 | 0 % | 0 | 0 | 1 |"));
  EXPECT_THAT(table, HasSubstr("| strangers | 1 | 0 | 0 % | 0 | 1 | 0 |"));
}

TEST(SearchTable, CountsWhoFindsAPlaceAlone) {
  JudgedPair pair;
  pair.scenario = "house";
  pair.overlap = 0.5;
  pair.hypotheses.resize(2);
  pair.hypotheses[0].rigid.source = GuessSource::kStructure;
  pair.hypotheses[0].right = true;
  pair.hypotheses[1].rigid.source = GuessSource::kPlaces;
  JudgedPair both = pair;
  both.hypotheses[1].right = true;
  EXPECT_THAT(SearchTable({pair, both, {.scenario = "house twin"}}),
              HasSubstr("| 0.30 and more | 2 | 2 | places 1, structure 2 | structure 1 |"));
  EXPECT_THAT(ToCsv({pair}), HasSubstr("\n0,house,0,0.500,0,structure,1,0,0,"));
}

}  // namespace
}  // namespace isthmus::bench
