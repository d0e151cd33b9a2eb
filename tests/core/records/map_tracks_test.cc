#include "core/records/map_tracks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <string>

namespace isthmus {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// A server whose map changes when a test says so. A session's poses lie at x = the number of its
// map's frame, so that two frames cannot be mixed up unseen.
class FakeMap {
 public:
  struct Place {
    std::string reference;  // Reference of the session's map; empty: in none.
    int frame = 0;
  };

  // Sessions in order of creation. Maps are numbered by how many sessions they have.
  void Put(const std::string& session, const std::string& reference, int frame) {
    places_[SessionId(session)] = {reference, frame};
    ++revision_;
  }

  MapInfo Info() const {
    MapInfo info;
    info.revision = revision_;
    for (const auto& [session, place] : places_) {
      const auto same =
          std::ranges::find(info.components, SessionId(place.reference), &Component::reference);
      if (same != info.components.end()) {
        same->sessions.push_back(session);
      } else {
        info.components.push_back({0, SessionId(place.reference), {session}, {}, 0, {}});
      }
    }
    std::ranges::stable_sort(info.components, std::greater(),
                             [](const Component& c) { return c.sessions.size(); });
    for (uint32_t i = 0; i < info.components.size(); ++i) info.components[i].component = i;
    return info;
  }

  // `before_way` is called before each question for a trajectory, with how many there were.
  TrackSource Source(const std::function<void(int)>& before_way = nullptr) {
    return {[this]() -> absl::StatusOr<MapInfo> {
              ++infos;
              return Info();
            },
            [this]() -> absl::StatusOr<std::vector<SessionRecord>> { return Sessions(); },
            [this, before_way](const SessionId& opened,
                               uint32_t segment) -> absl::StatusOr<RobotTrajectory> {
              if (before_way) before_way(ways++);
              const auto it = places_.find(SegmentId(opened, segment));
              if (it == places_.end()) return absl::NotFoundError("no such segment");
              RobotTrajectory way;
              way.revision = revision_;
              way.poses = {{segment, Pose(Eigen::Vector3d(it->second.frame, 0, 0))}};
              return way;
            }};
  }

  int infos = 0, ways = 0;

 private:
  std::vector<SessionRecord> Sessions() const {
    std::vector<SessionRecord> records;
    for (const auto& [id, place] : places_) {
      SessionRecord& record = records.emplace_back();
      record.id = id;
      record.robot = RobotId(id.value().substr(0, id.value().find('-')));
      const size_t dot = id.value().find('.');
      if (dot == std::string::npos) continue;
      record.first_segment = SessionId(id.value().substr(0, dot));
      record.segment = static_cast<uint32_t>(std::stoi(id.value().substr(dot + 1)));
    }
    return records;
  }

  std::map<SessionId, Place> places_;
  int64_t revision_ = 0;
};

// "alice-1:1" is the session and the frame of its first pose.
std::vector<std::string> Said(const absl::StatusOr<std::vector<Track>>& tracks) {
  std::vector<std::string> said;
  if (!tracks.ok()) return {tracks.status().ToString()};
  for (const Track& track : *tracks) {
    std::string text = track.session.value() + ":";
    for (const StampedPose& pose : track.poses) {
      text += std::to_string(static_cast<int>(pose.pose.translation().x()));
    }
    said.push_back(text);
  }
  return said;
}

// Map 0 is alice's, map 1 is bob's, with a segment of carol in each.
FakeMap MapsOfAliceAndBob() {
  FakeMap map;
  map.Put("alice-1", "alice-1", 1);
  map.Put("alice-2", "alice-1", 1);
  map.Put("bob-1", "bob-1", 2);
  map.Put("carol-1", "alice-1", 1);
  map.Put("carol-1.2", "bob-1", 2);
  map.Put("carol-1.3", "alice-1", 1);
  return map;
}

TEST(MapTracks, AreOfTheSessionsInTheMapAndOfTheirSegmentsThere) {
  FakeMap map = MapsOfAliceAndBob();
  const MapInfo info = map.Info();
  EXPECT_THAT(Said(ReadTracks(map.Source(), info, 0)),
              ElementsAre("alice-1:1", "alice-2:1", "carol-1:11"));
  EXPECT_THAT(Said(ReadTracks(map.Source(), info, 1)), ElementsAre("bob-1:2", "carol-1:2"));
  EXPECT_THAT(Said(ReadTracks(map.Source(), info, MapName(SessionId("carol-1.2")))),
              ElementsAre("bob-1:2", "carol-1:2"));
  EXPECT_THAT(Said(ReadTracks(map.Source(), info, 1, RobotId("carol"))), ElementsAre("carol-1:2"));
  EXPECT_EQ(map.infos, 0) << "nothing has changed since `info`";
  EXPECT_TRUE(absl::IsNotFound(ReadTracks(map.Source(), info, 2).status()));
  EXPECT_TRUE(absl::IsNotFound(ReadTracks(map.Source(), info, 0, RobotId("dave")).status()));
  EXPECT_TRUE(ReadTracks(FakeMap().Source(), MapInfo(), 0)->empty());
  const absl::Status elsewhere = ReadTracks(map.Source(), info, 0, RobotId("bob")).status();
  EXPECT_TRUE(absl::IsFailedPrecondition(elsewhere)) << elsewhere;
  EXPECT_THAT(std::string(elsewhere.message()), HasSubstr("but in map 1")) << elsewhere;
}

// The larger map is 0: while its ways are read the other one becomes that.
TEST(MapTracks, AreOfTheMapThatWasMeantWhenItsNumberPassesToAnother) {
  FakeMap map = MapsOfAliceAndBob();
  const auto grow = [&map](int asked) {
    if (asked != 1) return;
    for (const char* session : {"bob-2", "bob-3", "bob-4", "bob-5"}) map.Put(session, "bob-1", 2);
  };
  const MapInfo info = map.Info();
  EXPECT_THAT(Said(ReadTracks(map.Source(grow), info, 0)),
              ElementsAre("alice-1:1", "alice-2:1", "carol-1:11"));
  ASSERT_EQ(map.Info().components[0].reference, SessionId("bob-1"));
  EXPECT_EQ(map.ways, 4) << "the map is as it was: its ways are not asked for again";
}

TEST(MapTracks, AreInOneFrameWhenMapsJoinMeanwhile) {
  FakeMap map = MapsOfAliceAndBob();
  const auto join = [&map](int asked) {
    if (asked != 1) return;
    for (const char* session : {"bob-1", "carol-1.2"}) map.Put(session, "alice-1", 1);
  };
  const MapInfo info = map.Info();
  EXPECT_THAT(Said(ReadTracks(map.Source(join), info, 1)),
              ElementsAre("alice-1:1", "alice-2:1", "bob-1:1", "carol-1:111"));
}

TEST(MapTracks, OfAMapThatNeverStandsStillAreRefused) {
  FakeMap map = MapsOfAliceAndBob();
  const auto change = [&map](int asked) {
    if (asked % 4 != 0) return;  // Once while the four ways are read.
    for (const char* session : {"alice-1", "alice-2", "carol-1", "carol-1.3"}) {
      map.Put(session, asked % 8 == 0 ? "alice-2" : "alice-1", asked);
    }
  };
  const MapInfo info = map.Info();
  EXPECT_TRUE(absl::IsAborted(ReadTracks(map.Source(change), info, 0).status()));
}

TEST(MapTracks, TheNewestWayOfEachRobotIsTheLast) {
  FakeMap map = MapsOfAliceAndBob();
  auto tracks = ReadTracks(map.Source(), map.Info(), 0);
  ASSERT_TRUE(tracks.ok());
  tracks->at(1).poses.front().stamp_ns = 77;
  const auto ways = NewestWays(*tracks, {RobotId("bob"), RobotId("alice"), RobotId("carol")});
  ASSERT_EQ(ways.size(), 3u);
  EXPECT_TRUE(ways[0].empty());
  EXPECT_EQ(ways[1].front().stamp_ns, 77);
  EXPECT_EQ(ways[2].size(), 2u);
}

TEST(MapTracks, AStableNameIsTheReference) {
  const MapInfo info = MapsOfAliceAndBob().Info();
  EXPECT_EQ(*StableName(info, 1), MapName(SessionId("bob-1")));
  EXPECT_EQ(*StableName(info, MapName(SessionId("carol-1.2"))), MapName(SessionId("bob-1")));
  EXPECT_EQ(*StableName(MapInfo(), 0), MapName(0));
}

}  // namespace
}  // namespace isthmus
