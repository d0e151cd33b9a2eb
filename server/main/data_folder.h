// The folder the map lives in.
#pragma once

#include <absl/status/status.h>

#include <string>

namespace isthmus::server {

// Makes the folder and its parents where missing. FailedPrecondition when that cannot be done or a
// file cannot be written in it; the message says why.
absl::Status MakeDataFolder(const std::string& path);

// Notes in the folder that the map which belongs to it is kept in a database.
absl::Status NoteMapIsIn(const std::string& path, const std::string& database);
// FailedPrecondition where that is noted, saying where, and the folder has no map: to begin one
// would be a mistake.
absl::Status CheckMapIsHere(const std::string& path);

}  // namespace isthmus::server
