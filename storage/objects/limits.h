// The judged numbers of values that a bucket has in place of the database.
#pragma once

#include <absl/time/time.h>

#include <cstddef>

namespace isthmus::storage {

// Values below so many bytes stay in the database: a request to an object store costs as much as
// storing them there for years, and takes longer than a commit.
inline constexpr size_t kSmallestObject = 16'384;

// Time for which the same value is the same object, and number of such values that are known: while
// a database is away its writers try to commit again and again. Far less than objects without a
// reference stay (kUnreferencedStay), as the object may be one all that time.
inline constexpr absl::Duration kSameObject = absl::Hours(1);
inline constexpr size_t kKnownObjects = 256;
// Times that an object is read before it is taken for damaged: a proxy may answer for the object
// store.
inline constexpr int kReadings = 3;

}  // namespace isthmus::storage
