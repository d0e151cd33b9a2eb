#include "lab/bench/merging/drive_cache.h"

#include <absl/strings/str_cat.h>
#include <unistd.h>

#include <filesystem>
#include <system_error>

#include "core/odometry_mode.h"

namespace isthmus::bench {

namespace fs = std::filesystem;

DriveCache::DriveCache(const std::string& folder, const server::PipelineOptions& options)
    : folder_(folder.empty() ? temporary_.path() : folder), options_(options) {}

std::string DriveCache::FolderOf(const std::string& name) const {
  return absl::StrCat(folder_, "/", name, "-", ToString(options_.odometry.mode));
}

absl::StatusOr<DrivenRobot> DriveCache::Get(const DriveOptions& drive) {
  return Get(drive.Key(), [&] { return SimulateDrive(drive); });
}

absl::Status DriveCache::Fill(const DriveOptions& drive) {
  return Fill(drive.Key(), [&] { return SimulateDrive(drive); });
}

absl::StatusOr<DrivenRobot> DriveCache::Get(const std::string& name, const Maker& make) {
  if (absl::Status status = Fill(name, make); !status.ok()) return status;
  return LoadDrivenRobot(FolderOf(name));
}

absl::Status DriveCache::Fill(const std::string& name, const Maker& make) {
  const std::string folder = FolderOf(name);
  std::error_code error;
  if (fs::exists(folder, error)) return absl::OkStatus();
  const auto grounded = make();
  if (!grounded.ok()) return grounded.status();
  // Whole or not at all: another program may look for it meanwhile, or this one be ended.
  const std::string part = absl::StrCat(folder, ".part-", getpid());
  fs::remove_all(part, error);
  fs::create_directories(part, error);
  if (error) return absl::PermissionDeniedError(absl::StrCat("cannot make the folder ", part));
  absl::Status status = DriveThroughServer(*grounded, options_, part);
  if (status.ok()) fs::rename(part, folder, error);
  if (!status.ok() || error) fs::remove_all(part, error);
  return status.ok() && !fs::exists(folder, error)
             ? absl::UnavailableError(absl::StrCat("cannot keep a drive as ", folder))
             : status;
}

}  // namespace isthmus::bench
