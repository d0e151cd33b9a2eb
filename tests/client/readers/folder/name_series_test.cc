#include "client/readers/folder/name_series.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "client/readers/folder/name_times.h"

namespace isthmus::readers {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

using Names = std::vector<std::string>;

// In the order in which a folder would not give them.
NameSeries SeriesOf(Names& names) {
  std::reverse(names.begin(), names.end());
  return FindSeries(names);
}

Names InOrder(Names names) {
  const NameSeries series = SeriesOf(names);
  Names ordered;
  for (const size_t i : series.order) ordered.push_back(names[i]);
  return ordered;
}

// Nanoseconds from the first stamp; empty where names are no times, or not given in their order.
std::vector<int64_t> Stamps(Names names) {
  const Names wanted = names;
  NameSeries series = SeriesOf(names);
  const auto times = OrderByTimes(series);
  if (!times) return {};
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[series.order[i]] != wanted[i]) return {};
  }
  std::vector<int64_t> stamps = times->stamps_ns;
  for (int64_t& stamp : stamps) stamp -= times->stamps_ns.front();
  return stamps;
}

TEST(NameSeriesTest, NumbersGiveTheOrderWhereverTheyStand) {
  EXPECT_THAT(InOrder({"full0.pcd", "full2.pcd", "full10.pcd"}),
              ElementsAre("full0.pcd", "full2.pcd", "full10.pcd"));
  EXPECT_THAT(InOrder({"scan_1_v2.pcd", "scan_9_v2.pcd", "scan_130_v2.pcd"}),
              ElementsAre("scan_1_v2.pcd", "scan_9_v2.pcd", "scan_130_v2.pcd"));
  EXPECT_THAT(InOrder({"9.9.pcd", "10.0.pcd", "10.1.pcd"}),
              ElementsAre("9.9.pcd", "10.0.pcd", "10.1.pcd"));
  EXPECT_THAT(InOrder({"run2_9.pcd", "run10_1.pcd", "run10_2.pcd"}),
              ElementsAre("run2_9.pcd", "run10_1.pcd", "run10_2.pcd"));
  const std::string big(30, '9');
  EXPECT_THAT(InOrder({"8.pcd", "009.pcd", "1" + big + ".pcd", "2" + big + ".pcd"}),
              ElementsAre("8.pcd", "009.pcd", "1" + big + ".pcd", "2" + big + ".pcd"));
}

TEST(NameSeriesTest, NamesThatDoNotFitAreLeftOut) {
  const Names names = {"map_final.pcd", "10.pcd", "._9.pcd", "9.pcd", ".11.pcd", "11.pcd"};
  const NameSeries series = FindSeries(names);
  EXPECT_THAT(series.order, ElementsAre(3, 1, 5));
  EXPECT_THAT(series.left_out, ElementsAre(0, 2, 4));
}

TEST(NameSeriesTest, NamesThatMakeNoOneSeriesAllStay) {
  Names names = {"hall.pcd", "lobby_2.pcd", "lobby_10.pcd", "yard_1.pcd", "yard_2.pcd"};
  EXPECT_THAT(InOrder(names), testing::ElementsAreArray(names));
  EXPECT_EQ(FindSeries(names).pattern, "");
  EXPECT_THAT(FindSeries(names).left_out, IsEmpty());
}

TEST(NameSeriesTest, GapsOfASteadySeriesAreSteps) {
  const auto steps = [](const Names& names) { return FindSeries(names).Steps(); };
  EXPECT_THAT(steps({"0.bin", "1.bin", "2.bin", "3.bin", "6.bin"}), ElementsAre(0, 1, 2, 3, 6));
  EXPECT_THAT(steps({"a10.bin", "a15.bin", "a20.bin", "a25.bin", "a35.bin"}),
              ElementsAre(0, 1, 2, 3, 5));
  EXPECT_THAT(steps({"0.bin", "7.bin", "19.bin", "40.bin"}), IsEmpty()) << "keyframes";
  EXPECT_THAT(steps({"1.bin", "01.bin", "2.bin"}), IsEmpty()) << "a number twice";
}

TEST(NameTimesTest, Ros2WritesNanosecondsWithoutZeros) {
  EXPECT_THAT(Stamps({"1600000000.61100006.pcd", "1600000000.161099911.pcd",
                      "1600000000.261100054.pcd", "1600000000.361099958.pcd"}),
              ElementsAre(0, 99'999'905, 200'000'048, 299'999'952));
  EXPECT_THAT(Stamps({"1600000000_900000000.pcd", "1600000001_0.pcd", "1600000001_100000000.pcd"}),
              ElementsAre(0, 100'000'000, 200'000'000));
}

TEST(NameTimesTest, DecimalFractionsMayLackZerosAtTheirEnd) {
  EXPECT_THAT(Stamps({"1600000000.9.pcd", "1600000000.95.pcd", "1600000001.pcd",
                      "1600000001.05.pcd", "1600000001.1.pcd"}),
              ElementsAre(0, 50'000'000, 100'000'000, 150'000'000, 200'000'000));
  EXPECT_THAT(Stamps({"1305031102.175304.png.pcd", "1305031102.275304.png.pcd"}),
              ElementsAre(0, 100'000'000));
}

TEST(NameTimesTest, TheWholeSeriesDecides) {
  // Nothing but evenness tells these: neither has a zero at an end.
  Names decimal, counted;
  for (int i = 0; i < 40; ++i) {
    const int64_t ns = 13'000'007 + i * int64_t{50'000'001};
    char digits[32];
    std::snprintf(digits, sizeof(digits), "%09d", static_cast<int>(ns % 1'000'000'000));
    std::string text = digits;
    while (text.back() == '0') text.pop_back();
    decimal.push_back("s" + std::to_string(ns / 1'000'000'000) + "." + text + ".las");
    counted.push_back("s" + std::to_string(ns / 1'000'000'000) + "." +
                      std::to_string(ns % 1'000'000'000) + ".las");
  }
  for (const Names& names : {decimal, counted}) {
    const std::vector<int64_t> stamps = Stamps(names);
    ASSERT_EQ(stamps.size(), 40u);
    for (int i = 1; i < 40; ++i) EXPECT_EQ(stamps[i] - stamps[i - 1], 50'000'001) << i;
  }
}

TEST(NameTimesTest, SimulationsCountFromZero) {
  EXPECT_THAT(Stamps({"9.9.pcd", "10.0.pcd", "10.1.pcd"}),
              ElementsAre(0, 100'000'000, 200'000'000));
  EXPECT_THAT(Stamps({"9.95.pcd", "10.pcd", "10.05.pcd"}), ElementsAre(0, 50'000'000, 100'000'000));
  EXPECT_THAT(Stamps({"9900000000.pcd", "10000000000.pcd", "10100000000.pcd"}),
              ElementsAre(0, 100'000'000, 200'000'000));
  EXPECT_THAT(Stamps({"9900000.pcd", "10000000.pcd"}), ElementsAre(0, 100'000'000));
}

TEST(NameTimesTest, DatesAreTimes) {
  const Names names = {"2021-10-26-16-21-29-468.pcd", "2021-10-26-16-21-29-568.pcd",
                       "2021-10-26-16-21-30-068.pcd"};
  EXPECT_THAT(Stamps(names), ElementsAre(0, 100'000'000, 600'000'000));
  NameSeries one = FindSeries({names[0]});
  EXPECT_EQ(OrderByTimes(one)->stamps_ns[0], 1635265289'468'000'000);
  EXPECT_THAT(
      Stamps({"20211026_162129_868.pcd", "20211026_162129_968.pcd", "20211026_162130_68.pcd"}),
      ElementsAre(0, 100'000'000, 200'000'000));
  EXPECT_THAT(Stamps({"scan 2021-10-26 16.21.29.bin", "scan 2021-10-26 16.21.31.bin"}), IsEmpty())
      << "not a form that anybody is known to write";
  EXPECT_THAT(Stamps({"20211026235959.pcd", "20211027000000.pcd"}), ElementsAre(0, 1'000'000'000));
  EXPECT_THAT(Stamps({"2021-13-26-16-21-29.pcd", "2021-13-26-16-21-30.pcd"}), IsEmpty());
}

TEST(NameTimesTest, OneOfSeveralNumbersMayBeTheTime) {
  EXPECT_THAT(Stamps({"n015-2018-07-24-11-22-45+0800__LIDAR_TOP__1532402927647951.pcd.bin",
                      "n015-2018-07-24-11-22-45+0800__LIDAR_TOP__1532402927697951.pcd.bin"}),
              ElementsAre(0, 50'000'000));
  EXPECT_THAT(Stamps({"000001_1600000000.25.ply", "000002_1600000000.75.ply"}),
              ElementsAre(0, 500'000'000));
}

TEST(NameTimesTest, NumbersThatCountAreNoTimes) {
  EXPECT_THAT(Stamps({"0000000000.bin", "0000000001.bin"}), IsEmpty());
  EXPECT_THAT(Stamps({"2021-10-26-16-21-29_9.pcd", "2021-10-26-16-21-29_10.pcd"}), IsEmpty());
  EXPECT_THAT(Stamps({"1.8.pcd", "1.9.pcd", "1.10.pcd"}), IsEmpty()) << "1.10 is not 1.1";
  EXPECT_THAT(Stamps({"9999999999999.pcd", "9999999999998.pcd"}), IsEmpty()) << "the year 2286";
}

}  // namespace
}  // namespace isthmus::readers
