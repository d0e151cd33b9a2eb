#include "server/classes/forest.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>

namespace isthmus::classes {
namespace {

template <typename T>
void Put(T value, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(value));
}

void PutNode(float threshold, uint16_t feature, uint16_t next, std::string* bytes) {
  Put(threshold, bytes);
  Put(feature, bytes);
  Put(next, bytes);
}

// Two trees: the first asks whether feature 3 is at most 0.5, the second always says the same.
std::string SmallForest(uint16_t first_child = 1) {
  constexpr uint16_t kLeaf = 0xffff;
  std::string bytes;
  for (const uint32_t number :
       {0x524f4649u, 1u, uint32_t{kFeatures}, uint32_t{kPointClasses}, 2u}) {
    Put(number, &bytes);
  }
  Put(2.0F, &bytes);
  const auto put_leaf = [&bytes](size_t of) {
    std::string shares(kPointClasses, '\0');
    shares[of] = '\xff';
    bytes += shares;
  };
  Put<uint16_t>(3, &bytes);
  Put<uint16_t>(2, &bytes);
  PutNode(0.5F, 3, first_child, &bytes);
  PutNode(0, kLeaf, 0, &bytes);
  PutNode(0, kLeaf, 1, &bytes);
  put_leaf(1);
  put_leaf(3);
  Put<uint16_t>(1, &bytes);
  Put<uint16_t>(1, &bytes);
  PutNode(0, kLeaf, 0, &bytes);
  put_leaf(1);
  return bytes;
}

TEST(ForestTest, TellsTheMeanOfItsTreesSharpened) {
  const auto forest = Forest::Read(SmallForest());
  ASSERT_TRUE(forest.ok()) << forest.status();
  Features features = {};
  EXPECT_EQ(forest->Tell(features)[1], 1);
  features[3] = 0.6F;
  EXPECT_EQ(forest->Tell(features)[1], 0.5F);
  EXPECT_EQ(forest->Tell(features)[3], 0.5F);
  // A third tree of 2:1 for wall: shares of 1/3 and 2/3 are 1/5 and 4/5 to the power of two.
  std::string bytes = SmallForest();
  bytes[16] = 3;
  Put<uint16_t>(1, &bytes);
  Put<uint16_t>(1, &bytes);
  PutNode(0, 0xffff, 0, &bytes);
  std::string wall(kPointClasses, '\0');
  wall[3] = '\xff';
  const auto three = Forest::Read(bytes + wall);
  ASSERT_TRUE(three.ok()) << three.status();
  EXPECT_NEAR(three->Tell(features)[1], 0.2F, 0.01F);
  EXPECT_NEAR(three->Tell(features)[3], 0.8F, 0.01F);
}

TEST(ForestTest, RefusesWhatIsNoForest) {
  const std::string bytes = SmallForest();
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(Forest::Read(bytes.substr(0, size)).ok()) << size;
  }
  EXPECT_FALSE(Forest::Read(bytes + "x").ok());
  EXPECT_FALSE(Forest::Read(SmallForest(0)).ok());  // A node that is its own child.
  EXPECT_FALSE(Forest::Read(SmallForest(2)).ok());  // A child beyond the tree.
  std::string other = bytes;
  other[8] = static_cast<char>(kFeatures + 1);
  EXPECT_FALSE(Forest::Read(other).ok());
}

TEST(ForestTest, TheProgramsOwnIsSound) {
  const Shares shares = Forest::Own().Tell(Features{});
  float sum = 0;
  for (const float share : shares) sum += share;
  EXPECT_NEAR(sum, 1, 0.02F);
  EXPECT_EQ(shares[0], 0);
}

}  // namespace
}  // namespace isthmus::classes
