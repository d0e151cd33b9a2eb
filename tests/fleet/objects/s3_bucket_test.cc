#include "fleet/objects/s3_bucket.h"

#include <absl/time/clock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>

#include <string>
#include <vector>

#include "fleet/objects/limits.h"
#include "tests/fleet/objects/s3_server.h"

namespace isthmus::storage {
namespace {

using absl::StatusCode;

TEST(S3Bucket, GivesBackWhatItWasGiven) {
  const auto bucket = S3Bucket::Open(S3Server::Shared().NewUrl());
  ASSERT_TRUE(bucket.ok()) << bucket.status();
  std::string large(5'000'000, '\0');
  for (size_t i = 0; i < large.size(); ++i) large[i] = static_cast<char>(i * 2654435761u >> 13);
  for (const std::string& bytes : {large, std::string(), std::string("a\0b\r\n\xff", 6)}) {
    ASSERT_TRUE((*bucket)->Put("some/object-1.x", bytes).ok());
    const auto found = (*bucket)->Get("some/object-1.x");
    ASSERT_TRUE(found.ok()) << found.status();
    EXPECT_EQ(*found == bytes, true);
  }
  EXPECT_TRUE((*bucket)->Delete("some/object-1.x").ok());
  EXPECT_TRUE((*bucket)->Delete("some/object-1.x").ok());
  EXPECT_EQ((*bucket)->Get("some/object-1.x").status().code(), StatusCode::kNotFound);
}

TEST(S3Bucket, ListsMoreThanAPage) {
  const auto bucket = S3Bucket::Open(S3Server::Shared().NewUrl());
  ASSERT_TRUE(bucket.ok()) << bucket.status();
  const auto other = S3Bucket::Open(S3Server::Shared().NewUrl());
  ASSERT_TRUE((*other)->Put("a/0", "of another prefix").ok());
  std::vector<std::string> names;
  for (int i = 1000; i < 2001; ++i) names.push_back("a/" + std::to_string(i));
  for (const std::string& name : names) ASSERT_TRUE((*bucket)->Put(name, "x").ok());
  ASSERT_TRUE((*bucket)->Put("b/1", "x").ok());
  const auto listed = (*bucket)->List("a/");
  ASSERT_TRUE(listed.ok()) << listed.status();
  EXPECT_EQ(*listed, names);
  EXPECT_EQ((*bucket)->List("c/")->size(), 0u);
}

TEST(S3Bucket, SaysWhatIsWrong) {
  const std::string url = S3Server::Shared().NewUrl();
  for (const char* wrong : {"", "maps", "ftp://host/maps", "https://host", "https://host/",
                            "https://me:secret@host/maps", "https://host/maps?versions",
                            "https://host/a%20b", "https://host/maps?region=a&b"}) {
    EXPECT_EQ(CheckBucketUrl(wrong).code(), StatusCode::kInvalidArgument) << wrong;
  }
  EXPECT_TRUE(CheckBucketUrl("https://host:9000/maps/north/?region=eu-central-1").ok());

  setenv("AWS_SECRET_ACCESS_KEY", "another", 1);
  const auto refused = S3Bucket::Open(url);
  unsetenv("AWS_SECRET_ACCESS_KEY");
  const auto without = S3Bucket::Open(url);
  setenv("AWS_SECRET_ACCESS_KEY", "S3RVER", 1);
  EXPECT_EQ((*refused)->Put("x", "y").code(), StatusCode::kPermissionDenied);
  EXPECT_EQ((*refused)->List("").status().code(), StatusCode::kPermissionDenied);
  EXPECT_EQ(without.status().code(), StatusCode::kFailedPrecondition);

  const auto nowhere = S3Bucket::Open(S3Server::Shared().origin() + "/nobodys/x");
  const absl::Status none = (*nowhere)->Put("x", "y");
  EXPECT_EQ(none.code(), StatusCode::kFailedPrecondition);
  EXPECT_NE(none.message().find("NoSuchBucket"), std::string::npos) << none;
}

TEST(S3Bucket, IsThereAgainAfterItsServerWasAway) {
  const auto server = S3Server::Start();
  const auto bucket = S3Bucket::Open(server->NewUrl());
  ASSERT_TRUE((*bucket)->Put("x", "kept").ok());
  server->Kill();
  EXPECT_EQ((*bucket)->Get("x").status().code(), StatusCode::kUnavailable);
  EXPECT_EQ((*bucket)->Put("y", "lost").code(), StatusCode::kUnavailable);
  ASSERT_TRUE(server->StartAgain());
  const auto found = (*bucket)->Get("x");
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_EQ(*found, "kept");
  EXPECT_EQ((*bucket)->Get("y").status().code(), StatusCode::kNotFound);
}

// One after the other would wait until it is given up.
TEST(S3Bucket, WhileItHangsOneWaitsForAll) {
  const auto server = S3Server::Start();
  const auto bucket = S3Bucket::Open(server->NewUrl());
  ASSERT_TRUE((*bucket)->Put("x", "kept").ok());
  server->Signal(SIGSTOP);
  EXPECT_EQ((*bucket)->Get("x").status().code(), StatusCode::kUnavailable);
  const absl::Time begin = absl::Now();
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ((*bucket)->Put("y", "lost").code(), StatusCode::kUnavailable);
  }
  EXPECT_LT(absl::Now() - begin, absl::Seconds(kStandsStillS));
  server->Signal(SIGCONT);
  absl::StatusOr<std::string> found = absl::UnavailableError("not asked for yet");
  while (absl::IsUnavailable(found.status())) found = (*bucket)->Get("x");
  ASSERT_TRUE(found.ok()) << found.status();
  EXPECT_EQ(*found, "kept");
}

}  // namespace
}  // namespace isthmus::storage
