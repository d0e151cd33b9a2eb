#include "client/console/recording_report.h"

#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/codec/payload_builder.h"
#include "core/formats/pcd.h"

namespace isthmus::cli {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;

class RecordingReportTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto* info = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / "isthmus_recording_report" / info->name();
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  // Scan i, whose points have times of 0 where it `is_empty`.
  void AddScan(int i, bool is_empty) {
    std::vector<ScanPoint> points(10);
    for (size_t k = 0; k < points.size(); ++k) {
      points[k] = {.x = 5 + 0.1F * static_cast<float>(i),
                   .time = is_empty ? 0 : -0.01F * static_cast<float>(9 - k)};
    }
    ASSERT_TRUE(formats::WritePcd(folder_ / absl::StrCat(i, ".pcd"),
                                  codec::MakePayload(points, false, true),
                                  formats::PcdEncoding::kBinary)
                    .ok());
  }
  TopicReport Report() const {
    const auto report = ReadReport(folder_, {}, 1000, [] {});
    EXPECT_TRUE(report.ok()) << report.status();
    return report.ok() && report->topics.size() == 1 ? report->topics[0] : TopicReport();
  }

  fs::path folder_;
};

TEST_F(RecordingReportTest, TellsHowLongADriveTakesThoughItsClockWasSetBack) {
  std::string times;
  for (int i = 0; i < 30; ++i) {
    AddScan(i, false);
    absl::StrAppend(&times, (i < 15 ? 5000 : 1400) + 0.1 * i, "\n");
  }
  std::ofstream(folder_ / "times.txt") << times;
  const TopicReport report = Report();
  EXPECT_EQ(report.scans, 29u);  // The first behind the step cannot be told from one out of order.
  EXPECT_EQ(report.errors, 1u);
  EXPECT_NEAR(report.duration_s, 2.9, 1e-6);
  EXPECT_EQ(report.gaps, 0u);
  EXPECT_THAT(report.assumptions, Contains(HasSubstr("the stamps go back at")));
}

TEST_F(RecordingReportTest, EmptyTimesOfTheFirstScansAreNotThoseOfTheDrive) {
  for (int i = 0; i < 14; ++i) AddScan(i, i < 10);
  EXPECT_THAT(Report().times, HasSubstr("s, up to the end of the scan"));
  EXPECT_THAT(Report().assumptions, testing::Not(Contains(HasSubstr("compensated already"))));
  for (int i = 10; i < 14; ++i) AddScan(i, true);
  EXPECT_THAT(Report().times, HasSubstr("motion-compensated already"));
  EXPECT_THAT(Report().assumptions, Contains(HasSubstr("compensated already")));
}

}  // namespace
}  // namespace isthmus::cli
