#include "core/codec/column_transform.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <functional>
#include <string>

namespace isthmus::codec {
namespace {

constexpr size_t kPoints = 3000;

// n values of a record of twice their width, with bytes between them that must survive.
template <typename T>
std::string Column(const std::function<T(size_t)>& value_of, size_t n = kPoints) {
  std::string bytes(n * 2 * sizeof(T), '#');
  for (size_t i = 0; i < n; ++i) {
    const T value = value_of(i);
    std::memcpy(&bytes[i * 2 * sizeof(T)], &value, sizeof(T));
  }
  return bytes;
}

template <typename T>
Transform RoundTrip(const std::string& column) {
  const size_t n = column.size() / (2 * sizeof(T));
  std::string encoded = "before";
  const Transform transform = EncodeColumn(column.data(), 2 * sizeof(T), n, sizeof(T), encoded);
  EXPECT_EQ(encoded.size(), 6 + EncodedSize(transform, sizeof(T), n));
  std::string back(column.size(), '#');
  DecodeColumn(transform, &encoded[6], n, sizeof(T), back.data(), 2 * sizeof(T));
  EXPECT_EQ(back, column);
  return transform;
}

// Numbers without order (the finaliser of splitmix64).
uint64_t Scramble(uint64_t i) {
  i = (i + 1) * 0x9E3779B97F4A7C15;
  i = (i ^ (i >> 30)) * 0xBF58476D1CE4E5B9;
  i = (i ^ (i >> 27)) * 0x94D049BB133111EB;
  return i ^ (i >> 31);
}

TEST(ColumnTransform, TakesDifferencesOfTimesAndRings) {
  EXPECT_EQ(RoundTrip<uint32_t>(Column<uint32_t>([](size_t i) { return 55'296 * i; })),
            Transform::kDelta);
  EXPECT_EQ(RoundTrip<double>(Column<double>([](size_t i) { return 1.7e9 + 1e-4 * i; })),
            Transform::kDelta);
  EXPECT_EQ(RoundTrip<uint16_t>(Column<uint16_t>([](size_t i) { return i % 64; })),
            Transform::kDelta);
}

TEST(ColumnTransform, TakesAPaletteForFewLevels) {
  const auto hundredths = [](size_t i) { return static_cast<float>(Scramble(i) % 100) / 100; };
  EXPECT_EQ(RoundTrip<float>(Column<float>(hundredths)), Transform::kPalette);
  const auto levels = [](uint64_t count) {
    return [count](size_t i) { return Scramble(i) % count * 0x123456789ABCDu; };
  };
  EXPECT_EQ(RoundTrip<uint64_t>(Column<uint64_t>(levels(256))), Transform::kPalette);
  EXPECT_EQ(RoundTrip<uint64_t>(Column<uint64_t>(levels(257))), Transform::kPlain);
}

TEST(ColumnTransform, LeavesTheRestAsItIs) {
  EXPECT_EQ(RoundTrip<float>(Column<float>([](size_t i) { return 1.0f * Scramble(i); })),
            Transform::kPlain);
  EXPECT_EQ(RoundTrip<uint8_t>(Column<uint8_t>([](size_t i) { return Scramble(i); })),
            Transform::kPlain);
  // Too few points for a palette to pay.
  EXPECT_EQ(RoundTrip<float>(Column<float>([](size_t i) { return Scramble(i) % 9; }, 20)),
            Transform::kPlain);
  RoundTrip<uint16_t>(Column<uint16_t>([](size_t) { return 7; }, 1));
}

}  // namespace
}  // namespace isthmus::codec
