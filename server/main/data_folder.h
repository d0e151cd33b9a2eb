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
// Refuses a folder without a database in which to begin a map would be a mistake:
// FailedPrecondition where it is noted that the map is elsewhere, saying where; DataLoss where
// other files of a map are there.
absl::Status CheckMapIsHere(const std::string& path);

}  // namespace isthmus::server
