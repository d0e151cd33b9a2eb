#include "server/web/stream_slots.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace isthmus::web {
namespace {

TEST(StreamSlots, OneAddressHasNotAllOfThem) {
  StreamSlots slots(4, 3);
  std::vector<std::unique_ptr<StreamSlots::Slot>> taken;
  for (int port = 0; port < 3; ++port) {
    taken.push_back(slots.Take("ipv4:10.0.0.1:" + std::to_string(port)));
    EXPECT_NE(taken.back(), nullptr);
  }
  EXPECT_EQ(slots.Take("ipv4:10.0.0.1:9"), nullptr);
  auto other = slots.Take("ipv6:[::1]:1");
  EXPECT_NE(other, nullptr);
  EXPECT_EQ(slots.Take("ipv4:10.0.0.2:1"), nullptr);
  taken.pop_back();
  EXPECT_NE(slots.Take("ipv4:10.0.0.1:9"), nullptr);  // And gives it up again.
  other.reset();
  taken.push_back(slots.Take("ipv4:10.0.0.1:9"));
  EXPECT_NE(taken.back(), nullptr);
}

}  // namespace
}  // namespace isthmus::web
