#include "core/io/crc32c.h"

#include <gtest/gtest.h>

#include <string>

namespace isthmus::io {
namespace {

// Test patterns of RFC 3720, B.4.
TEST(Crc32c, MatchesTheStandard) {
  EXPECT_EQ(Crc32c("123456789", 9), 0xE3069283u);
  EXPECT_EQ(Crc32c(std::string(32, '\0').data(), 32), 0x8A9136AAu);
  EXPECT_EQ(Crc32c(std::string(32, '\xFF').data(), 32), 0x62A8AB43u);
  EXPECT_EQ(Crc32c(nullptr, 0), 0u);
}

TEST(Crc32c, BothFormsAgreeAndContinue) {
  std::string bytes;
  for (int i = 0; i < 1000; ++i) bytes.push_back(static_cast<char>(i * 37 + i / 7));
  for (size_t size = 0; size < 70; ++size) {
    for (size_t start = 0; start < 9; ++start) {
      EXPECT_EQ(Crc32c(&bytes[start], size), internal::Crc32cPortable(&bytes[start], size));
    }
  }
  const uint32_t whole = Crc32c(bytes.data(), bytes.size());
  for (const size_t cut : {1, 8, 333, 999}) {
    const uint32_t first = Crc32c(bytes.data(), cut);
    EXPECT_EQ(Crc32c(&bytes[cut], bytes.size() - cut, first), whole);
  }
}

}  // namespace
}  // namespace isthmus::io
