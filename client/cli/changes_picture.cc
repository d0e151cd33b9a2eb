#include "client/cli/changes_picture.h"

#include <absl/strings/str_cat.h>

#include <cstddef>
#include <vector>

#include "client/console/region_reader.h"
#include "client/evaluation/picture.h"
#include "client/exports/changes.h"

namespace isthmus::cli {

absl::Status DrawChanges(client::Client& client, const RegionQuery& region,
                         const ChangeList& changes, const std::string& path) {
  const auto read = ReadRegion(client, region);
  if (!read.ok()) return read.status();
  if (read->points.empty()) return absl::FailedPreconditionError("the map has no points there");
  std::vector<std::string> names;
  for (const RobotId& robot : read->robots) names.push_back(robot.value());
  evaluation::PictureOptions options;
  options.caption =
      absl::StrCat("revision ", changes.revision, ", green came, red went, x and y in m");
  Box extent = evaluation::PictureExtent(read->points, {});
  for (const ChangedVolume& volume : changes.volumes) {
    for (const Eigen::Vector3d& corner : exports::FootOf(volume)) extent.Extend(corner);
  }
  auto picture = evaluation::TopDownPicture::Create(extent, names, options);
  if (!picture.ok()) return picture.status();
  picture->Add(read->points);
  for (const ChangedVolume& volume : changes.volumes) {
    std::vector<Eigen::Vector2d> corners;
    for (const Eigen::Vector3d& corner : exports::FootOf(volume)) {
      corners.emplace_back(corner.head<2>());
    }
    const evaluation::Color green = {0, 150, 50}, red = {220, 30, 30};
    picture->AddOutline(std::move(corners), volume.came ? green : red);
  }
  return picture->WritePng(path);
}

}  // namespace isthmus::cli
