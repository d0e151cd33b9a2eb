#include "client/readers/stamps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "core/codec/column.h"

namespace isthmus::readers {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int64_t kStamp = 1'700'000'000'000'000'000;
constexpr int64_t kTurn = 100'000'000;

// A cloud whose points have these times, in a field of that type; none where it is empty.
PointPayload Cloud(const std::vector<double>& times, ScalarType type = ScalarType::kFloat64,
                   const char* name = "time") {
  PointPayload payload;
  payload.fields = {{"x", 0, ScalarType::kFloat32},
                    {"y", 4, ScalarType::kFloat32},
                    {"z", 8, ScalarType::kFloat32}};
  if (!times.empty()) payload.fields.push_back({name, 16, type});
  payload.stride = 24;
  payload.width = std::max<uint32_t>(1, static_cast<uint32_t>(times.size()));
  payload.data.assign(size_t{payload.width} * payload.stride, '\0');
  for (size_t i = 0; i < payload.width; ++i) {
    codec::StoreAs(5.0f, payload.data.data() + i * payload.stride);
    if (times.empty()) continue;
    codec::VisitScalar(type, [&](auto scalar) {
      codec::StoreAs(static_cast<decltype(scalar)>(times[i]),
                     payload.data.data() + i * payload.stride + 16);
    });
  }
  return payload;
}

int64_t End(ScanStamps& stamps, const PointPayload& payload, int64_t header_ns) {
  const auto end = stamps.End(payload, header_ns, kStamp + 7);
  EXPECT_TRUE(end.ok()) << end.status();
  return end.value_or(0);
}

TEST(ScanStampsTest, TimesFromZeroUpMakeTheStampTheStart) {
  ScanStamps seconds(StampMeaning::kByTimes, 10);
  EXPECT_NEAR(End(seconds, Cloud({0, 0.05, 0.1}), kStamp) - kStamp, kTurn, 2);
  EXPECT_THAT(seconds.Assumptions(), ElementsAre(HasSubstr("START of scans")));
  ScanStamps ns(StampMeaning::kByTimes, 10);
  EXPECT_EQ(End(ns, Cloud({0, 5e7, 9.9e7}, ScalarType::kUint32, "t"), kStamp), kStamp + 99'000'000);
}

TEST(ScanStampsTest, TimesUpToZeroMakeTheStampTheEnd) {
  ScanStamps stamps(StampMeaning::kByTimes, 10);
  EXPECT_NEAR(End(stamps, Cloud({-0.1, -0.05, 0}), kStamp) - kStamp, 0, 2);
  EXPECT_THAT(stamps.Assumptions(), ElementsAre(HasSubstr("END of scans")));
}

TEST(ScanStampsTest, AClockTellsTheEnd) {
  ScanStamps stamps(StampMeaning::kByTimes, 10);
  const double start = 1e-9 * kStamp + 0.3;
  EXPECT_NEAR(
      End(stamps, Cloud({start, start + 0.1}, ScalarType::kFloat64, "timestamp"), kStamp) - kStamp,
      400'000'000, 500);
  EXPECT_THAT(stamps.Assumptions(), ElementsAre(HasSubstr("points' clock")));
}

TEST(ScanStampsTest, AnotherClockKeepsItsDistance) {
  ScanStamps stamps(StampMeaning::kByTimes, 10);
  const int64_t first = End(stamps, Cloud({50.0, 50.1}), kStamp);
  EXPECT_EQ(first, kStamp);
  // The header is late by 30 ms; the points' clock is not.
  EXPECT_NEAR(End(stamps, Cloud({50.1, 50.2}), kStamp + kTurn + 30'000'000) - kStamp, kTurn, 500);
  EXPECT_THAT(stamps.Assumptions(), ElementsAre(HasSubstr("first header's stamp")));
}

TEST(ScanStampsTest, APartOfATurnEndsWhereAWholeOneWould) {
  ScanStamps stamps(StampMeaning::kByTimes, 10);
  End(stamps, Cloud({0, 0.05, 0.1}), kStamp);
  EXPECT_NEAR(End(stamps, Cloud({0, 0.02, 0.03}), kStamp + kTurn) - kStamp, 2 * kTurn, 2);
}

TEST(ScanStampsTest, TimesThatCannotBeUnderstoodLeaveTheLengthOfTheScanBefore) {
  ScanStamps stamps(StampMeaning::kByTimes, 10);
  End(stamps, Cloud({0, 0.05, 0.1}), kStamp);
  EXPECT_NEAR(End(stamps, Cloud({0, 777, 1e5}), kStamp + kTurn) - kStamp, 2 * kTurn, 2);
}

TEST(ScanStampsTest, WithoutTimesTheStampIsTheEnd) {
  ScanStamps stamps(StampMeaning::kByTimes, 10);
  EXPECT_EQ(End(stamps, Cloud({}), kStamp), kStamp);
  EXPECT_THAT(stamps.Assumptions(), ElementsAre(HasSubstr("points have no times")));
}

TEST(ScanStampsTest, WhatIsSaidIsBelieved) {
  ScanStamps start(StampMeaning::kStart, 20);
  EXPECT_EQ(End(start, Cloud({}), kStamp), kStamp + 50'000'000);
  ScanStamps by_times(StampMeaning::kStart, 20);
  EXPECT_NEAR(End(by_times, Cloud({-0.1, 0}), kStamp) - kStamp, kTurn, 2);
  ScanStamps end(StampMeaning::kEnd, 20);
  EXPECT_EQ(End(end, Cloud({0, 0.1}), kStamp), kStamp);
  EXPECT_THAT(end.Assumptions(), IsEmpty());
}

TEST(ScanStampsTest, WithoutAStampItIsWhenItWasRecorded) {
  ScanStamps stamps(StampMeaning::kByTimes, 10);
  EXPECT_EQ(End(stamps, Cloud({0, 0.1}), 0), kStamp + 7);
  EXPECT_THAT(stamps.Assumptions(), ElementsAre(HasSubstr("times of recording")));
}

TEST(ScanStampsTest, StampsThatDoNotIncreaseAreNamed) {
  ScanStamps stamps(StampMeaning::kEnd, 10);
  End(stamps, Cloud({}), kStamp);
  for (const int64_t stamp : {kStamp, kStamp - 1}) {
    const auto end = stamps.End(Cloud({}), stamp, 0);
    EXPECT_THAT(
        std::string(end.status().message()),
        testing::AllOf(HasSubstr(std::to_string(stamp)), HasSubstr(std::to_string(kStamp))));
  }
  EXPECT_EQ(End(stamps, Cloud({}), kStamp + 1), kStamp + 1);
}

TEST(ScanStampsTest, OneWildStampDoesNotCostAllThatFollow) {
  ScanStamps stamps(StampMeaning::kEnd, 10);
  const PointPayload cloud = Cloud({});
  EXPECT_EQ(End(stamps, cloud, kStamp), kStamp);
  EXPECT_EQ(End(stamps, cloud, kStamp + 3600 * 10 * kTurn), kStamp + 3600 * 10 * kTurn);
  EXPECT_FALSE(stamps.End(cloud, kStamp + kTurn, kStamp).ok());
  EXPECT_EQ(End(stamps, cloud, kStamp + 2 * kTurn), kStamp + 2 * kTurn);
  EXPECT_EQ(End(stamps, cloud, kStamp + 3 * kTurn), kStamp + 3 * kTurn);
  EXPECT_THAT(stamps.Assumptions(), testing::Contains(HasSubstr("go back")));
}

TEST(ScanStampsTest, WhatIsSentTwiceOrSwappedIsLeftOutAlone) {
  ScanStamps stamps(StampMeaning::kEnd, 10);
  const PointPayload cloud = Cloud({});
  EXPECT_EQ(End(stamps, cloud, kStamp + 2 * kTurn), kStamp + 2 * kTurn);
  EXPECT_FALSE(stamps.End(cloud, kStamp + kTurn, kStamp).ok());
  EXPECT_FALSE(stamps.End(cloud, kStamp + kTurn, kStamp).ok());
  EXPECT_EQ(End(stamps, cloud, kStamp + 3 * kTurn), kStamp + 3 * kTurn);
}

}  // namespace
}  // namespace isthmus::readers
