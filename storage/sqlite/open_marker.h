// Files beside the database that tell of a store that died, and of a copy that did not finish.
//
// A marker lies there while a store is open: a store that died leaves it behind. SQLite leaves its
// log behind too, and takes it in at the next start; without the marker, a log that somebody took
// away would not be missed.
#pragma once

#include <string>

namespace isthmus::storage {

class OpenMarker {
 public:
  // The store does without it if it cannot be made.
  explicit OpenMarker(const std::string& directory);
  // To be destroyed while the log is still there: between the two, nothing is missing.
  ~OpenMarker();
  // A store has the folder open, or died with it open.
  static bool IsIn(const std::string& directory);
  OpenMarker(const OpenMarker&) = delete;
  OpenMarker& operator=(const OpenMarker&) = delete;

 private:
  const std::string path_;
};

// The message about a folder whose store died and whose log is gone; empty if all is well.
std::string MissingLog(const std::string& directory);

// The database of a copy that is not finished: it becomes isthmus.db once it is whole.
std::string PartialDatabase(const std::string& directory);

// The message about a folder that has nothing but such a copy; empty if all is well.
std::string UnfinishedCopy(const std::string& directory);

}  // namespace isthmus::storage
