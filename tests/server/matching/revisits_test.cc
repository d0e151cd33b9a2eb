#include "server/matching/loops/revisits.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <set>
#include <utility>

#include "server/matching/prepared/prepared_map.h"
#include "server/matching/prepared/visibility.h"
#include "tests/server/matching/scene.h"

namespace isthmus::matching {
namespace {

// A hall of 20 by 12 m with a wall in it that may be taken away.
Scene MakeHall(bool with_wall) {
  Scene hall;
  hall.boxes.push_back({{10, 6, -0.1}, {10.2, 6.2, 0.1}});
  hall.boxes.push_back({{10, 6, 4.1}, {10.2, 6.2, 0.1}});
  hall.boxes.push_back({{-0.1, 6, 2}, {0.1, 6.2, 2}});
  hall.boxes.push_back({{20.1, 6, 2}, {0.1, 6.2, 2}});
  hall.boxes.push_back({{10, -0.1, 2}, {10.2, 0.1, 2}});
  hall.boxes.push_back({{10, 12.1, 2}, {10.2, 0.1, 2}});
  hall.boxes.push_back({{5, 9, 1}, {0.5, 0.5, 1}, 0.4});
  if (with_wall) hall.boxes.push_back({{13, 9, 2}, {0.1, 2, 2}});
  return hall;
}

const std::vector<Eigen::Vector3d>& AcrossTheHall() {
  static const std::vector<Eigen::Vector3d> way = Way({{4, 4, 1}, {16, 6, 1}}, 5);
  return way;
}

// One submap of a drive across the hall; frame: the world's.
std::shared_ptr<const Submap> PassBy(bool with_wall, unsigned seed) {
  return Survey(MakeHall(with_wall), {AcrossTheHall(), Pose(), 0.01, seed}).submaps.front();
}

// A map of a session that drives across again and again.
class Laps {
 public:
  void Add(const std::shared_ptr<const Submap>& look, const Pose& T_map_world = Pose(),
           uint32_t component = 0, const std::string& session = "laps-0001") {
    auto submap = std::make_shared<Submap>(*look);
    submap->id = {SessionId(session), next_++};
    submap->robot = RobotId(session.substr(0, session.find('-')));
    submap->first_stamp_ns = 1000 * int64_t{submap->id.index};
    submap->last_stamp_ns = submap->first_stamp_ns + 900;
    placed.push_back({std::make_shared<const SubmapInfo>(Summarize(*submap)), component,
                      T_map_world * submap->T_odom_submap});
    submaps_[submap->id] = std::move(submap);
  }

  // Reads what was added, but for what is in `damaged`.
  PreparedReader Reader() const {
    return [this](const SubmapId& id) {
      return damaged.contains(id.index) ? nullptr : PrepareSubmap(submaps_.at(id));
    };
  }

  // Indices of what may go.
  std::set<uint32_t> Update(RevisitCounter* counter, double hours = 0) const {
    std::set<uint32_t> going;
    const auto finished_ns = [this](const SessionId& session) {
      const auto found = finished_h.find(session.value());
      return found == finished_h.end() ? 0 : Ns(found->second);
    };
    for (const SubmapId& id : counter->Update(placed, Ns(hours), finished_ns)) {
      going.insert(id.index);
    }
    return going;
  }

  void Delete(const std::string& session) {
    std::erase_if(placed, [&](const PlacedSubmap& one) {
      return one.submap->id.session == SessionId(session);
    });
  }

  std::vector<PlacedSubmap> placed;
  std::set<uint32_t> damaged;                // Indices.
  std::map<std::string, double> finished_h;  // Sessions that are.

 private:
  static int64_t Ns(double hours) { return static_cast<int64_t>(3600e9 * hours); }

  std::map<SubmapId, std::shared_ptr<const Submap>> submaps_;
  uint32_t next_ = 0;
};

class RevisitsTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    for (unsigned seed = 0; seed < 3; ++seed) {
      looks_.push_back(PassBy(false, seed));
      with_wall_.push_back(PassBy(true, seed));
    }
  }

  static const std::shared_ptr<const Submap>& Nth(size_t i) { return looks_[i % looks_.size()]; }

  static inline std::vector<std::shared_ptr<const Submap>> looks_, with_wall_;
  const RevisitOptions options_{.min_looks = 3, .keep_newest = 2, .grace_h = 0};
};

TEST_F(RevisitsTest, TheOldestGoWhenSeenOftenEnough) {
  Laps laps;
  RevisitCounter counter(options_, laps.Reader());
  for (size_t i = 0; i < 3; ++i) {
    laps.Add(Nth(i));
    EXPECT_TRUE(laps.Update(&counter).empty()) << i;
  }
  laps.Add(Nth(3));
  EXPECT_EQ(laps.Update(&counter), std::set<uint32_t>{0});
  // The retired submap is gone; the rest goes on being counted.
  laps.placed.erase(laps.placed.begin());
  laps.Add(Nth(4));
  EXPECT_EQ(laps.Update(&counter), std::set<uint32_t>{1});
}

TEST_F(RevisitsTest, AMapDrivenOverForeverStaysSmall) {
  Laps laps;
  RevisitCounter counter(options_, laps.Reader());
  for (size_t i = 0; i < 16; ++i) {
    laps.Add(Nth(i));
    const std::set<uint32_t> going = laps.Update(&counter);
    std::erase_if(laps.placed,
                  [&](const PlacedSubmap& one) { return going.count(one.submap->id.index) > 0; });
    EXPECT_LE(laps.placed.size(), 4u);
  }
  EXPECT_EQ(laps.placed.back().submap->id.index, 15u);
}

TEST_F(RevisitsTest, TheNewestStay) {
  RevisitOptions options = options_;
  options.keep_newest = 10;
  Laps laps;
  RevisitCounter counter(options, laps.Reader());
  for (size_t i = 0; i < 10; ++i) {
    laps.Add(Nth(i));
    EXPECT_TRUE(laps.Update(&counter).empty());
  }
}

// The old wall is looked through: the submap that shows it goes like any other.
TEST_F(RevisitsTest, AWallThatWentAwayLeaves) {
  Laps laps;
  RevisitCounter counter(options_, laps.Reader());
  laps.Add(with_wall_[0]);
  for (size_t i = 0; i < 3; ++i) laps.Add(Nth(i));
  EXPECT_EQ(laps.Update(&counter), std::set<uint32_t>{0});
}

// Placed askew, a later submap looks through most walls of the older one.
TEST_F(RevisitsTest, WhatLiesInTheWrongPlaceDoesNotCount) {
  Laps laps;
  RevisitCounter counter(options_, laps.Reader());
  laps.Add(Nth(0));
  const Pose T_wrong = Pose::FromXyzRpy(10, -8, 0, 0, 0, 1.2);
  for (size_t i = 0; i < 8; ++i) laps.Add(Nth(i), T_wrong);
  EXPECT_EQ(laps.Update(&counter).count(0), 0u);
  EXPECT_EQ(laps.Update(&counter).count(0), 0u);
}

TEST_F(RevisitsTest, AnotherComponentDoesNotCount) {
  Laps laps;
  RevisitCounter counter(options_, laps.Reader());
  laps.Add(Nth(0));
  for (size_t i = 0; i < 5; ++i) laps.Add(Nth(i), Pose(), 1, "other-0001");
  EXPECT_EQ(laps.Update(&counter).count(0), 0u);
}

// Robots that come by later by turns make another one's submaps superfluous too.
TEST_F(RevisitsTest, OtherSessionsCount) {
  RevisitOptions options = options_;
  options.keep_newest = 0;
  Laps laps;
  RevisitCounter counter(options, laps.Reader());
  laps.Add(Nth(0));
  size_t next = 0;
  for (const char* session : {"bob-1", "carol-1", "bob-1"}) {
    EXPECT_TRUE(laps.Update(&counter).empty());
    laps.Add(Nth(next++), Pose(), 0, session);
  }
  EXPECT_EQ(laps.Update(&counter), std::set<uint32_t>{0});
}

// A client that replays another's recording under its own name takes nothing off the map.
TEST_F(RevisitsTest, HoweverOftenOneStrangerLooksNothingOfAnothersGoes) {
  RevisitOptions options = options_;
  options.keep_newest = 0;
  Laps laps;
  RevisitCounter counter(options, laps.Reader());
  for (size_t i = 0; i < 2; ++i) laps.Add(Nth(i), Pose(), 0, "alice-1");
  for (const char* session : {"mallory-1", "mallory-2", "mallory-3", "mallory-4"}) {
    for (size_t i = 0; i < 3; ++i) laps.Add(Nth(i), Pose(), 0, session);
    const std::set<uint32_t> going = laps.Update(&counter);
    EXPECT_FALSE(going.contains(0));
    EXPECT_FALSE(going.contains(1));
  }
}

TEST_F(RevisitsTest, WhatMayGoStaysForAWhileAndADeletedSessionTakesItsLooksBack) {
  RevisitOptions options = options_;
  options.grace_h = 24;
  Laps laps;
  RevisitCounter counter(options, laps.Reader());
  for (size_t i = 0; i < 3; ++i) laps.Add(Nth(i), Pose(), 0, "alice-1");
  laps.Add(Nth(3), Pose(), 0, "bob-1");
  EXPECT_TRUE(laps.Update(&counter, 0).empty());
  EXPECT_TRUE(laps.Update(&counter, 23.9).empty());
  laps.Delete("bob-1");
  EXPECT_TRUE(laps.Update(&counter, 24.1).empty());
  EXPECT_TRUE(laps.Update(&counter, 99).empty());
  // Another takes its place: the day begins anew.
  laps.Add(Nth(3), Pose(), 0, "carol-1");
  EXPECT_TRUE(laps.Update(&counter, 100).empty());
  EXPECT_TRUE(laps.Update(&counter, 123.9).empty());
  EXPECT_EQ(laps.Update(&counter, 124), std::set<uint32_t>{0});
}

// A server that is started each morning has never run for a day.
TEST_F(RevisitsTest, AStartDoesNotBeginTheGraceAgain) {
  RevisitOptions options = options_;
  options.grace_h = 24;
  Laps laps;
  for (size_t i = 0; i < 3; ++i) laps.Add(Nth(i), Pose(), 0, "alice-1");
  laps.Add(Nth(3), Pose(), 0, "bob-1");
  RevisitCounter first(options, laps.Reader());
  EXPECT_TRUE(laps.Update(&first, 8).empty());
  laps.finished_h = {{"alice-1", 9}, {"bob-1", 10}};
  // The looks of a day after are not those that made it superfluous.
  laps.Add(Nth(4), Pose(), 0, "carol-1");
  RevisitCounter second(options, laps.Reader());
  EXPECT_TRUE(laps.Update(&second, 32).empty()) << "bob may have looked until 10 h";
  EXPECT_TRUE(laps.Update(&second, 33.9).empty());
  RevisitCounter third(options, laps.Reader());
  EXPECT_EQ(laps.Update(&third, 34), std::set<uint32_t>{0});
}

// Deleting the session takes its looks and what they looked at.
TEST_F(RevisitsTest, LooksOfTheSameSessionNeedNoGrace) {
  RevisitOptions options = options_;
  options.grace_h = 24;
  Laps laps;
  RevisitCounter counter(options, laps.Reader());
  for (size_t i = 0; i < 4; ++i) laps.Add(Nth(i));
  EXPECT_EQ(laps.Update(&counter, 0), std::set<uint32_t>{0});
}

TEST_F(RevisitsTest, WhatCannotBeReadStays) {
  Laps laps;
  laps.damaged = {0};
  RevisitCounter counter(options_, laps.Reader());
  for (size_t i = 0; i < 8; ++i) {
    laps.Add(Nth(i));
    EXPECT_EQ(laps.Update(&counter).count(0), 0u) << i;
  }
}

TEST_F(RevisitsTest, NothingGoesUnlessAsked) {
  RevisitOptions options = options_;
  options.retire = false;
  Laps laps;
  RevisitCounter counter(options, laps.Reader());
  for (size_t i = 0; i < 8; ++i) laps.Add(Nth(i));
  EXPECT_TRUE(laps.Update(&counter).empty());
}

TEST_F(RevisitsTest, WhatWasLookedAt) {
  const PreparedSubmap later(looks_[0]);
  const Pose T_later_world = looks_[0]->T_odom_submap.Inverse();
  const std::vector<Eigen::Vector3f> points = {{10, 0, 1.2f},   // On the long wall,
                                               {13, 8, 1.2f},   // in the open,
                                               {10, -3, 1.2f},  // behind the wall,
                                               {6, 4.5f, 30}};  // above everything.
  const std::vector<Visibility> looks = VisibilityOf(points, later, T_later_world);
  EXPECT_EQ(looks, (std::vector<Visibility>{Visibility::kOn, Visibility::kThrough,
                                            Visibility::kNone, Visibility::kNone}));
}

}  // namespace
}  // namespace isthmus::matching
