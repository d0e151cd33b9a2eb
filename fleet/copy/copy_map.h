// A map taken from one database to another, record by record as it is.
#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>

namespace isthmus::storage {

// A map folder, or a database where it begins with postgresql://. In a database, the map of a site:
// empty, the default one; and the bucket for the large values (s3_bucket.h), if any, of a map that
// is to be made.
struct MapPlace {
  std::string where;
  std::string site = {};
  std::string bucket = {};
};

struct CopyReport {
  int64_t schema = 0;
  int64_t sessions = 0, submaps = 0, scans = 0, matches = 0, revisions = 0, events = 0;
  int64_t records = 0;  // Records of all tables.
};

// Copies all records of `from`, as of one moment, to `to`, where there must be no map yet; then
// reads them back and compares count and checksum of every table. All or nothing: until that was
// done nothing is committed. No server may be on either (FailedPrecondition, naming it); other
// files beside a map in its folder (archived scans, tokens) stay there.
//
// NotFound where there is no map at `from`, FailedPrecondition where it has not the newest schema,
// AlreadyExists where there is a map at `to`, DataLoss when the copy read back differs or `from`
// cannot be read.
absl::StatusOr<CopyReport> CopyMap(const MapPlace& from, const MapPlace& to);

}  // namespace isthmus::storage
