// A store of objects by name, outside of the database.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <string>
#include <vector>

namespace isthmus::storage {

// Names are letters, digits and /._-. Thread safe. Errors: Unavailable where the bucket is not to
// be reached or has an error of its own, PermissionDenied where it refuses the credentials,
// NotFound for an object that is not there, and FailedPrecondition for any other refusal; all with
// its own words.
class Bucket {
 public:
  virtual ~Bucket() = default;

  // Once it returns OK the bucket has the object.
  virtual absl::Status Put(const std::string& name, const std::string& bytes) = 0;
  virtual absl::StatusOr<std::string> Get(const std::string& name) = 0;
  virtual absl::Status Delete(const std::string& name) = 0;  // One that is not there is no error.
  // All names that begin so, in order.
  virtual absl::StatusOr<std::vector<std::string>> List(const std::string& beginning) = 0;
};

}  // namespace isthmus::storage
