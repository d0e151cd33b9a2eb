// Hashes of the images of an Ouster sensor's frames, as ouster-sdk publishes them.
#pragma once

#include <absl/status/statusor.h>

#include <string>
#include <vector>

namespace isthmus::bench {

struct DigestLine {
  std::string field;  // "RANGE"
  std::string theirs, ours;
  bool same() const { return theirs == ours; }
};

// The fields of the first scan in the digest that our packets hold too: MD5 of the image, row by
// row, uppermost first, columns as measured, little endian. The messages of errors name the file.
absl::StatusOr<std::vector<DigestLine>> CompareDigest(const std::string& capture,
                                                      const std::string& metadata,
                                                      const std::string& digest);

}  // namespace isthmus::bench
