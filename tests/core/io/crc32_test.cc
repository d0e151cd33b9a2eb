#include "core/io/crc32.h"

#include <gtest/gtest.h>

#include <string>

namespace isthmus::io {
namespace {

TEST(Crc32, HasItsKnownValues) {
  EXPECT_EQ(Crc32(""), 0u);
  EXPECT_EQ(Crc32({}), 0u);
  EXPECT_EQ(Crc32("123456789"), 0xCBF43926u);
  EXPECT_EQ(Crc32(std::string(32, '\0')), 0x190A55ADu);
}

TEST(Crc32, Continues) {
  std::string bytes;
  for (int i = 0; i < 1000; ++i) bytes.push_back(static_cast<char>(i * 37 + i / 7));
  const absl::string_view whole = bytes;
  for (const size_t cut : {0, 1, 8, 333, 999, 1000}) {
    EXPECT_EQ(Crc32(whole.substr(cut), Crc32(whole.substr(0, cut))), Crc32(whole)) << cut;
  }
  EXPECT_EQ(Crc32({}, Crc32(whole)), Crc32(whole));
}

}  // namespace
}  // namespace isthmus::io
