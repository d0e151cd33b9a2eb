// Drives that are kept on disk, because simulating them and their odometry is what takes long.
#pragma once

#include <absl/status/statusor.h>

#include <functional>
#include <string>

#include "lab/bench/merging/drive_options.h"
#include "lab/bench/merging/driven_robot.h"
#include "lab/bench/merging/temporary_folder.h"
#include "server/pipeline_options.h"

namespace isthmus::bench {

// Not thread safe; several programs may use one folder. Drives of an older odometry are not told
// apart from those of today: after a change of it use another folder.
class DriveCache {
 public:
  // Keeps drives in `folder`, which is made if need be; if it is empty, in one that is removed with
  // this object. `options` say how drives are made; the odometry's mode is part of their names.
  DriveCache(const std::string& folder, const server::PipelineOptions& options);

  // Simulates what is not there. Errors as SimulateDrive, and of writing files.
  absl::StatusOr<DrivenRobot> Get(const DriveOptions& drive);
  // The same without reading it.
  absl::Status Fill(const DriveOptions& drive);

  using Maker = std::function<absl::StatusOr<GroundedDrive>()>;
  // The drive of that name; `make` is asked for it if it is not there.
  absl::StatusOr<DrivenRobot> Get(const std::string& name, const Maker& make);

 private:
  std::string FolderOf(const std::string& name) const;
  absl::Status Fill(const std::string& name, const Maker& make);

  TemporaryFolder temporary_;
  std::string folder_;
  server::PipelineOptions options_;
};

}  // namespace isthmus::bench
