// A server that is built without fleet/ and so without maps in databases.
#include "server/main/database_maps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace isthmus::server {
namespace {

TEST(WithoutDatabaseMaps, TheConfigurationMayNameNoDatabase) {
  ServerConfig config;
  EXPECT_TRUE(CheckDatabase(config).ok());
  config.store = "postgresql://db/isthmus";
  const absl::Status refused = CheckDatabase(config);
  EXPECT_TRUE(absl::IsInvalidArgument(refused));
  EXPECT_THAT(std::string(refused.message()), testing::HasSubstr("storage.store"));
  EXPECT_EQ(OpenDatabaseMap(config, "", {}, nullptr).status(), refused);
  EXPECT_EQ(OpenFollowedMap(config, "").status(), refused);
  config.store.clear();
  config.bucket = "https://minio:9000/maps";
  EXPECT_TRUE(absl::IsInvalidArgument(CheckDatabase(config)));
}

}  // namespace
}  // namespace isthmus::server
