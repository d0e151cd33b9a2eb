#include "client/readers/stamps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

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
  return stamps.End(payload, header_ns, kStamp + 7);
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

TEST(ScanStampsTest, TimesOfZeroAreThoseOfACompensatedScan) {
  for (const auto meaning : {StampMeaning::kByTimes, StampMeaning::kStart, StampMeaning::kEnd}) {
    ScanStamps stamps(meaning, 10);
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(End(stamps, Cloud({0, 0, 0}), kStamp + i * kTurn), kStamp + i * kTurn);
    }
  }
}

TEST(ScanStampsTest, AnOddTimeMovesNoEnd) {
  for (const double odd : {std::nan(""), 1e300, 77.0, -3.0}) {
    ScanStamps stamps(StampMeaning::kByTimes, 10);
    for (int scan = 0; scan < 3; ++scan) {
      std::vector<double> times;
      for (int i = 0; i <= 100; ++i) times.push_back(1e-3 * i);
      times[static_cast<size_t>(10 * scan)] = odd;
      EXPECT_NEAR(End(stamps, Cloud(times), kStamp + scan * kTurn) - kStamp, (scan + 1) * kTurn, 2);
    }
  }
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

TEST(ScanStampsTest, WithoutAStampAClockOfUnixTimeTells) {
  ScanStamps stamps(StampMeaning::kByTimes, 10);
  const double start = 1e-9 * kStamp - 0.5;
  EXPECT_NEAR(End(stamps, Cloud({start, start + 0.1}), 0) - kStamp, -400'000'000, 500);
  EXPECT_THAT(stamps.Assumptions(), ElementsAre(HasSubstr("points' clock is the END")));
  ScanStamps since_boot(StampMeaning::kByTimes, 10);
  EXPECT_EQ(End(since_boot, Cloud({50.0, 50.1}), 0), kStamp + 7);
}

TEST(ScanStampsTest, OneStampThatIsMissingIsTheClocks) {
  ScanStamps stamps(StampMeaning::kByTimes, 10);
  EXPECT_EQ(End(stamps, Cloud({50.0, 50.1}), kStamp), kStamp);
  EXPECT_NEAR(End(stamps, Cloud({50.1, 50.2}), 0) - kStamp, kTurn, 500);
  EXPECT_NEAR(End(stamps, Cloud({50.2, 50.3}), kStamp + 2 * kTurn) - kStamp, 2 * kTurn, 500);
}

TEST(ScanStampsTest, APointWithoutATimeChangesNothing) {
  for (const size_t at : {0, 1, 3}) {
    ScanStamps stamps(StampMeaning::kByTimes, 10);
    const PointPayload whole = Cloud({0, 3e7, 6e7, 1e8}, ScalarType::kUint32, "t");
    std::vector<double> times = {0, 3e7, 6e7, 1e8};
    times.insert(times.begin() + static_cast<std::ptrdiff_t>(at), 4294967295.0);
    for (int scan = 0; scan < 6; ++scan) {
      const auto cloud = scan == 0 || scan == 3 ? Cloud(times, ScalarType::kUint32, "t") : whole;
      EXPECT_NEAR(End(stamps, cloud, kStamp + scan * kTurn) - kStamp, (scan + 1) * kTurn, 2);
    }
    EXPECT_THAT(stamps.Assumptions(), ElementsAre(HasSubstr("START of scans")));
  }
}

// Scans of 0.1 s for 15 s, their times modulo `modulus` ns.
void ExpectUnwrapped(int64_t modulus, int64_t start_ns) {
  ScanStamps stamps(StampMeaning::kByTimes, 10);
  const int64_t first = End(stamps,
                            Cloud({static_cast<double>(start_ns % modulus),
                                   static_cast<double>((start_ns + kTurn) % modulus)},
                                  ScalarType::kUint32, "t"),
                            kStamp + kTurn);
  for (int64_t scan = 1; scan < 150; ++scan) {
    std::vector<double> times;
    for (int64_t part = 0; part <= 10; ++part) {
      const int64_t t = start_ns + scan * kTurn + part * kTurn / 10;
      times.push_back(static_cast<double>(t % modulus));
    }
    // Headers are late by up to 0.1 s.
    const int64_t header_ns = kStamp + (scan + 1) * kTurn + (scan % 3) * 50'000'000;
    EXPECT_NEAR(End(stamps, Cloud(times, ScalarType::kUint32, "t"), header_ns) - first,
                scan * kTurn, 10)
        << modulus << " " << start_ns << " " << scan;
  }
}

TEST(ScanStampsTest, CountersThatStartAgainAreUnwrapped) {
  // Within a scan, between two, and while it is small.
  for (const double start_s : {3.03, 3.294967296, 0.7}) {
    ExpectUnwrapped(int64_t{1} << 32, std::llround(start_s * 1e9));
  }
  ExpectUnwrapped(1'000'000'000, 730'000'000);
}

TEST(ScanStampsTest, StampsFarFromAnyClockAreNone) {
  ScanStamps stamps(StampMeaning::kByTimes, 10);
  const int64_t wild = std::numeric_limits<int64_t>::min() + 1;
  EXPECT_EQ(End(stamps, Cloud({0, 0.1}), wild), kStamp + 7);
  EXPECT_NEAR(End(stamps, Cloud({1e13, 1e13 + 0.1}), kStamp + kTurn) - kStamp, kTurn, 2);
}

TEST(ScanStampsTest, StampsThatGoBackStayAsTheyAre) {
  ScanStamps stamps(StampMeaning::kEnd, 10);
  const PointPayload cloud = Cloud({});
  for (const int64_t late : {0, 2, 1, 36000, 3, -36000}) {
    EXPECT_EQ(End(stamps, cloud, kStamp + late * kTurn), kStamp + late * kTurn);
  }
}

// Clouds that differ, as those of a sensor do.
PointPayload CloudNumber(int i) {
  PointPayload cloud = Cloud({});
  codec::StoreAs(1.0f + static_cast<float>(i), cloud.data.data() + 4);
  return cloud;
}

TEST(ScanStampsTest, WhereHeadersStandStillTheTimesOfRecordingTell) {
  ScanStamps stamps(StampMeaning::kByTimes, 10);
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(stamps.End(CloudNumber(i), 42, kStamp + i * kTurn), 42 + i * kTurn);
  }
  EXPECT_THAT(stamps.Assumptions(), testing::Contains(HasSubstr("stand still")));
}

TEST(ScanStampsTest, WhereHeadersHaveWholeSecondsTheTimesOfRecordingTell) {
  ScanStamps stamps(StampMeaning::kByTimes, 10);
  for (int i = 0; i < 25; ++i) {
    const int64_t second_ns = kStamp + i / 10 * 10 * kTurn;
    EXPECT_EQ(stamps.End(CloudNumber(i), second_ns, kStamp + i * kTurn), kStamp + i * kTurn);
  }
}

TEST(ScanStampsTest, AMessageThatCameTwiceIsNoStandstill) {
  ScanStamps stamps(StampMeaning::kByTimes, 10);
  EXPECT_EQ(stamps.End(CloudNumber(0), kStamp, kStamp), kStamp);
  EXPECT_EQ(stamps.End(CloudNumber(0), kStamp, kStamp + 5), kStamp);
  EXPECT_EQ(stamps.End(CloudNumber(1), kStamp + kTurn, kStamp + kTurn + 10), kStamp + kTurn);
}

}  // namespace
}  // namespace isthmus::readers
