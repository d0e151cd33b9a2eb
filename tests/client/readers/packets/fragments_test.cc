#include "client/readers/packets/capture/fragments.h"

#include <gtest/gtest.h>

#include <string>

namespace isthmus::readers::capture {
namespace {

IpPacket Piece(uint32_t id, size_t offset, const std::string& bytes, bool more) {
  IpPacket packet;
  packet.protocol = 17;
  packet.id = id;
  packet.offset = static_cast<uint32_t>(offset);
  packet.more = more;
  packet.fragment = true;
  packet.payload = bytes;
  packet.length = bytes.size();
  return packet;
}

TEST(FragmentJoiner, TakesAnyOrderAndTwice) {
  FragmentJoiner joiner;
  const std::string a(8, 'a'), b(16, 'b'), c(3, 'c');
  EXPECT_FALSE(joiner.Add(Piece(1, 24, c, false), 0));
  EXPECT_FALSE(joiner.Add(Piece(1, 8, b, true), 0));
  EXPECT_FALSE(joiner.Add(Piece(1, 8, b, true), 0));
  const auto whole = joiner.Add(Piece(1, 0, a, true), 0);
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->payload, a + b + c);
  EXPECT_FALSE(whole->fragment);
  EXPECT_EQ(joiner.lost(), 0u);
}

TEST(FragmentJoiner, RefusesWhatLies) {
  FragmentJoiner joiner;
  const std::string a(8, 'a'), odd(7, 'a'), large(60000, 'a');
  EXPECT_FALSE(joiner.Add(Piece(1, 0, "", false), 0));
  EXPECT_FALSE(joiner.Add(Piece(1, 0, odd, true), 0));
  EXPECT_FALSE(joiner.Add(Piece(1, 65528, a, false), 0));
  EXPECT_FALSE(joiner.Add(Piece(1, 8000, large, false), 0));
  IpPacket cut = Piece(1, 0, a, true);
  cut.length = 100;
  EXPECT_FALSE(joiner.Add(cut, 0));
  EXPECT_EQ(joiner.lost(), 0u);
}

TEST(FragmentJoiner, DoesNotMixOldAndNew) {
  FragmentJoiner joiner;
  const std::string old_bytes(8, 'o'), new_bytes(8, 'n');
  EXPECT_FALSE(joiner.Add(Piece(1, 0, old_bytes, true), 0));
  // The number comes again a minute later.
  EXPECT_FALSE(joiner.Add(Piece(1, 8, new_bytes, false), 60'000'000'000));
  const auto whole = joiner.Add(Piece(1, 0, new_bytes, true), 60'000'000'000);
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->payload, new_bytes + new_bytes);
  EXPECT_EQ(joiner.lost(), 1u);
}

TEST(FragmentJoiner, GivesUpTheOldest) {
  FragmentJoiner joiner;
  const std::string a(8, 'a');
  for (uint32_t id = 0; id < 100; ++id) joiner.Add(Piece(id, 0, a, true), 0);
  EXPECT_EQ(joiner.lost(), 100u);  // Sixteen of these may still be completed.
  EXPECT_TRUE(joiner.Add(Piece(99, 8, a, false), 0));
  EXPECT_FALSE(joiner.Add(Piece(1, 8, a, false), 0));
}

}  // namespace
}  // namespace isthmus::readers::capture
