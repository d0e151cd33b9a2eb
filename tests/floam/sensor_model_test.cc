#include "floam/sensor_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace isthmus::floam {
namespace {

TEST(SensorModel, EveryNamedModelIsConsistent) {
  for (const std::string& name : SensorModelNames()) {
    const auto model = FindSensorModel(name);
    ASSERT_TRUE(model.ok()) << name;
    EXPECT_EQ(model->name, name);
    EXPECT_EQ(model->elevations.size(), static_cast<size_t>(model->rings)) << name;
    EXPECT_TRUE(std::is_sorted(model->elevations.begin(), model->elevations.end())) << name;
    EXPECT_LT(model->min_range_m, model->max_range_m) << name;
  }
}

TEST(SensorModel, AnUnknownOneListsTheKnownOnes) {
  const auto model = FindSensorModel("vlp17");
  ASSERT_EQ(model.status().code(), absl::StatusCode::kNotFound);
  const std::string message(model.status().message());
  for (const std::string& name : SensorModelNames()) {
    EXPECT_THAT(message, ::testing::HasSubstr(name));
  }
}

}  // namespace
}  // namespace isthmus::floam
