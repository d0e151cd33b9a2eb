#include "client/readers/folder/scan_files.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <set>
#include <system_error>
#include <utility>

#include "core/formats/cloud_file.h"

namespace isthmus::readers {
namespace {

namespace fs = std::filesystem;

std::string Extension(const fs::path& file) {
  return absl::AsciiStrToLower(file.extension().string());
}

bool IsScan(const fs::path& file) {
  const std::string extension = Extension(file);
  return extension == ".bin" ||
         (formats::IsCloudFile(extension) && !formats::IsTextFile(extension));
}

bool IsTextScan(const fs::path& file) {
  const std::string extension = Extension(file);
  if (!formats::IsTextFile(extension)) return false;
  // times.txt, poses.txt and readme.txt are none.
  return extension != ".txt" || absl::ascii_isdigit(file.filename().string().front());
}

absl::StatusOr<std::vector<fs::path>> ListScans(const fs::path& folder) {
  std::vector<fs::path> scans, texts;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    std::error_code ignored;
    if (!entry.is_regular_file(ignored)) continue;
    if (IsScan(entry.path())) scans.push_back(entry.path());
    if (IsTextScan(entry.path())) texts.push_back(entry.path());
  }
  if (error) {
    return absl::UnavailableError(
        absl::StrCat("cannot list ", folder.string(), ": ", error.message()));
  }
  return scans.empty() ? texts : scans;
}

// The files of the series that their names make, in order.
ScanFiles InOrder(const fs::path& folder, const std::vector<fs::path>& files) {
  std::vector<std::string> names;
  names.reserve(files.size());
  for (const fs::path& file : files) names.push_back(file.filename().string());
  ScanFiles found;
  found.folder = folder;
  found.series = FindSeries(names);
  found.times = OrderByTimes(found.series);
  for (const size_t i : found.series.order) found.files.push_back(files[i]);
  for (const size_t i : found.series.left_out) found.left_out.push_back(names[i]);
  std::sort(found.left_out.begin(), found.left_out.end());
  return found;
}

absl::StatusOr<ScanFiles> ScansOfFolder(const fs::path& path) {
  // In the order in which they are looked for: the folder itself comes first.
  for (const char* inside : {"", "velodyne_points/data", "data", "velodyne", "scans"}) {
    const fs::path folder = *inside == '\0' ? path : path / inside;
    std::error_code error;
    if (!fs::is_directory(folder, error)) continue;
    absl::StatusOr<std::vector<fs::path>> files = ListScans(folder);
    if (!files.ok()) return files.status();
    ScanFiles found = InOrder(folder, *files);
    if (!found.files.empty()) return found;
  }
  return absl::NotFoundError(
      absl::StrCat(path.string(), " holds no scans: no .bin, .pcd, .ply, .las and no .csv files"));
}

}  // namespace

absl::StatusOr<ScanFiles> FindScans(const std::string& path) {
  std::error_code error;
  ScanFiles found;
  if (fs::is_directory(path, error)) {
    absl::StatusOr<ScanFiles> scans = ScansOfFolder(path);
    if (!scans.ok()) return scans.status();
    found = *std::move(scans);
  } else if (fs::is_regular_file(path, error)) {
    if (!IsScan(path) && !formats::IsTextFile(Extension(path))) {
      return absl::InvalidArgumentError(absl::StrCat(path, " is no recording that can be read"));
    }
    found.files = {path};
    found.folder = found.files.front().parent_path();
    found.series = FindSeries({found.files.front().filename().string()});
    found.times = OrderByTimes(found.series);
    found.is_one_file = true;
  } else {
    return absl::NotFoundError(absl::StrCat(path, " does not exist"));
  }
  std::set<std::string> extensions;
  for (const fs::path& file : found.files) extensions.insert(Extension(file));
  if (extensions.size() > 1) {
    return absl::InvalidArgumentError(
        absl::StrCat(found.folder.string(), " holds both ", *extensions.begin(), " and ",
                     *extensions.rbegin(), " files: which ones are the scans?"));
  }
  found.extension = *extensions.begin();
  return found;
}

fs::path WholeName(const fs::path& folder) {
  std::error_code error;
  const fs::path whole = fs::absolute(folder, error).lexically_normal();
  // "scans/" has an empty last component.
  return whole.has_filename() ? whole : whole.parent_path();
}

std::optional<fs::path> FindBeside(const fs::path& folder, const char* name) {
  std::error_code error;
  const fs::path whole = WholeName(folder);
  for (const fs::path& place : {whole, whole.parent_path()}) {
    if (fs::is_regular_file(place / name, error)) return place / name;
  }
  return std::nullopt;
}

}  // namespace isthmus::readers
