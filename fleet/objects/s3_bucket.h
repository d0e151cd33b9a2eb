// A bucket of an object store that speaks the protocol of Amazon's S3.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>
#include <absl/time/time.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/concurrency/mutex.h"
#include "storage/objects/bucket.h"

namespace isthmus::storage {

// InvalidArgument for a text that is no URL of a bucket, and for one with a password in it: it
// would be seen by `ps`, in the log and in the printed configuration. A bucket's is
// https://HOST/BUCKET[/PREFIX][?region=REGION], or http:; without a region it is us-east-1.
absl::Status CheckBucketUrl(const std::string& url);

// Names stand behind the prefix of the bucket's URL. Each request has a connection of its own; one
// that fails on the way is tried again, for seconds.
class S3Bucket : public Bucket {
 public:
  // Asks the object store nothing yet. Credentials are those of the environment, as Amazon's
  // programs take them: AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and, where there is one,
  // AWS_SESSION_TOKEN. Errors as CheckBucketUrl; FailedPrecondition without credentials.
  static absl::StatusOr<std::unique_ptr<S3Bucket>> Open(const std::string& url);
  ~S3Bucket() override;

  absl::Status Put(const std::string& name, const std::string& bytes) override;
  absl::StatusOr<std::string> Get(const std::string& name) override;
  absl::Status Delete(const std::string& name) override;
  absl::StatusOr<std::vector<std::string>> List(const std::string& beginning) override;

 private:
  struct Credentials {
    std::string key_id, secret, session_token;
  };
  struct Request {
    std::string method, name = {}, query = {};
    absl::string_view body = {};
  };
  struct Answer {
    int64_t code = 0;
    std::string body;
  };
  class Transfer;

  S3Bucket(std::string origin, std::string path, std::string region, Credentials credentials);
  absl::StatusOr<std::string> Ask(const Request& request);
  absl::StatusOr<Answer> AskOnce(const Request& request);
  absl::Status IsAway();  // Not OK: it was so a moment ago.
  std::unique_ptr<Transfer> Borrow();
  void Return(std::unique_ptr<Transfer> transfer);

  const std::string origin_, bucket_, prefix_, region_;  // The prefix ends with /, or is empty.
  const Credentials credentials_;
  Mutex mutex_;
  std::vector<std::unique_ptr<Transfer>> idle_ ABSL_GUARDED_BY(mutex_);  // Their connections stay.
  absl::Status away_ ABSL_GUARDED_BY(mutex_);
  absl::Time away_until_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
};

}  // namespace isthmus::storage
