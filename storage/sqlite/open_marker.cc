#include "storage/sqlite/open_marker.h"

#include <absl/strings/str_cat.h>

#include <filesystem>
#include <fstream>
#include <system_error>

namespace isthmus::storage {
namespace {

std::string PathIn(const std::string& directory) { return directory + "/isthmus.open"; }

}  // namespace

OpenMarker::OpenMarker(const std::string& directory) : path_(PathIn(directory)) {
  std::ofstream file(path_);
  file << "A store has this map open, or died with it open.\n";
}

OpenMarker::~OpenMarker() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

bool OpenMarker::IsIn(const std::string& directory) {
  std::error_code error;
  return std::filesystem::exists(PathIn(directory), error) && !error;
}

std::string MissingLog(const std::string& directory) {
  std::error_code error;
  const std::string log = directory + "/isthmus.db-wal";
  if (!OpenMarker::IsIn(directory)) return "";
  if (std::filesystem::exists(log, error) || error) return "";
  return absl::StrCat(
      log,
      " is missing, though the map was not closed when it was last used: unless "
      "another program has taken it in, what was stored last is gone with it, and a "
      "backup is the way back");
}

std::string PartialDatabase(const std::string& directory) {
  return directory + "/isthmus.db.partial";
}

std::string UnfinishedCopy(const std::string& directory) {
  std::error_code error;
  const std::string partial = PartialDatabase(directory);
  if (std::filesystem::exists(directory + "/isthmus.db", error)) return "";
  if (!std::filesystem::exists(partial, error)) return "";
  return absl::StrCat(partial,
                      " is what a copy left that did not finish: run isthmus copy again, or remove "
                      "the file");
}

}  // namespace isthmus::storage
