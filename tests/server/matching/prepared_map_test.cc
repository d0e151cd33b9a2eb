// A map that has grown is the map that is made at once, to the last bit.
#include "server/matching/prepared/prepared_map.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "server/matching/prepared/map_poses.h"
#include "tests/server/matching/scene.h"

namespace isthmus::matching {
namespace {

SessionMap First(const SessionMap& map, size_t count) {
  SessionMap first = map;
  first.submaps.resize(count);
  return first;
}

SessionMap ElevenSubmaps() {
  const std::vector<Eigen::Vector3d> corners = {{-12, -7, 1.2}, {-3, -7, 1.2}, {-3, 6, 1.2},
                                                {12, 6, 1.2},   {12, -6, 1.2}, {4, -6, 1.2}};
  Drive drive{Way(corners, 55), Pose()};
  drive.azimuths = 120;
  return Survey(MakeGallery(), drive);
}

// All that a match may follow from.
std::vector<double> Numbers(const PreparedMap& map) {
  std::vector<double> numbers;
  const auto add = [&](const auto& matrix) {
    for (Eigen::Index i = 0; i < matrix.size(); ++i) numbers.push_back(matrix.data()[i]);
  };
  add(map.T_level_odom().Matrix());
  numbers.push_back(map.may_be_upside_down());
  for (const auto& piece : map.free_space().pieces()) {
    for (const FreeSpaceMap::Column& column : piece->columns) {
      for (const SurfacePoint& point : column.points) add(point.position);
    }
  }
  for (const Place& place : map.places()) add(place.T_odom_place.Matrix());
  numbers.push_back(map.own_agreement().upright_ratio());
  numbers.push_back(map.own_agreement().residual_m());
  const MapPoses poses = MapPoses::Rigid(map.session_map(), map.session_map(), Pose());
  for (size_t k = 0; k < map.submaps().size(); ++k) {
    numbers.push_back(map.distinctive().Has(map.submaps()[k]->surface()[k].position));
    const ThingAgreement things = map.things().In(map.things(), k, poses.a[k], poses.b);
    numbers.push_back(static_cast<double>(things.there));
    numbers.push_back(static_cast<double>(things.gone));
  }
  add(map.whole().walls.T_level_odom().Matrix());
  return numbers;
}

TEST(PreparedMapTest, IsMadeOfAQuarterMoreAtATime) {
  std::vector<size_t> levelled;
  for (size_t count = 0; count <= 13; ++count) levelled.push_back(LevelledAt(count));
  EXPECT_EQ(levelled, (std::vector<size_t>{0, 1, 2, 3, 4, 5, 5, 7, 7, 9, 9, 9, 12, 12}));
}

TEST(PreparedMapTest, HasTheSameBitsWhetherItHasGrownOrNot) {
  const SessionMap whole = ElevenSubmaps();
  ASSERT_EQ(whole.submaps.size(), 11u);
  // Somebody may ask it for more while it grows, or nobody.
  for (const bool is_asked : {false, true}) {
    auto grown = std::make_shared<const PreparedMap>(First(whole, 4));
    for (const size_t count : {5, 6, 8, 9, 11}) {
      if (is_asked) (void)Numbers(*grown);
      grown = std::make_shared<const PreparedMap>(First(whole, count), *grown);
      EXPECT_EQ(Numbers(*grown), Numbers(PreparedMap(First(whole, count)))) << count;
    }
  }
}

TEST(PreparedMapTest, HasTheSameBitsAfterSubmapsWereRetired) {
  const SessionMap whole = ElevenSubmaps();
  SessionMap rest = whole;
  rest.submaps.erase(rest.submaps.begin() + 1);
  const PreparedMap before(First(whole, 8));
  const PreparedMap after(rest, before);
  EXPECT_EQ(Numbers(after), Numbers(PreparedMap(rest)));
  EXPECT_EQ(after.submaps()[1], before.submaps()[2]) << "it need not be prepared again";
}

}  // namespace
}  // namespace isthmus::matching
