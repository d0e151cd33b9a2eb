#include "floam/rings/sensor_model.h"

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
    if (!model->elevations.empty()) {
      EXPECT_EQ(model->elevations.size(), static_cast<size_t>(model->rings)) << name;
    }
    EXPECT_TRUE(model->spins || model->rings == 0) << name;
    EXPECT_TRUE(std::is_sorted(model->elevations.begin(), model->elevations.end())) << name;
    EXPECT_LT(model->min_range_m, model->max_range_m) << name;
  }
}

TEST(SensorModel, ThoseThatDoNotSpinAreKnown) {
  for (const char* name : {"Livox Mid-360", "mid360s", "MID40", "livox-mid70", "Avia", "Horizon",
                           "Tele-15", "solid", "solid state", "unordered", "any", "Livox"}) {
    const auto model = FindSensorModel(name);
    ASSERT_TRUE(model.ok()) << name;
    EXPECT_FALSE(model->spins) << name;
  }
  for (const char* name : {"Velodyne VLP-32C", "spinning", "auto", "Quanergy M8", "vls128"}) {
    EXPECT_TRUE(FindSensorModel(name)->spins) << name;
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
