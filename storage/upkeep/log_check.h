// A check whether a write-ahead log of SQLite breaks off before its end.
#pragma once

#include <string>

#include "storage/upkeep/check_store.h"

namespace isthmus::storage {

// SQLite takes the log at `path` up to the first frame whose checksum is wrong, and says nothing of
// the rest. A power cut may leave the last transaction like that, which was not acknowledged then;
// what is broken before another one has begun is damage. No log is none.
//
// Source of the format: https://www.sqlite.org/fileformat2.html, "The Write-Ahead Log".
void CheckLog(const std::string& path, StoreReport& report);

}  // namespace isthmus::storage
