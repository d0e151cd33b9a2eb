// Merged maps from above, as pictures for reports.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "client/evaluation/canvas.h"
#include "core/cloud.h"
#include "core/map/trajectory.h"

namespace isthmus::evaluation {

struct PictureOptions {
  int max_side_px = 1600;  // The longer side; 200 to 10000.
  bool dark = false;       // Light on black instead of dark on white.
  double point_m = 0.12;   // Size of a point; the spacing of the map's points leaves no gaps.
  // Points below and above are left out: floor and ceiling, say. In the map frame.
  double min_z_m = -std::numeric_limits<double>::infinity();
  double max_z_m = std::numeric_limits<double>::infinity();
  bool legend = true;  // Scale bar and names.
  bool grid = true;    // Lines at round coordinates of the map, named, and a cross at its origin.
  std::string caption = {};  // Below the legend: of when and of what the picture is.
};

// A picture that points are added to, piece by piece. x is to the right, y up; points outside of
// the extent are not drawn. A pixel is the darker the more heights have points in it, so walls
// stand out against floors without a cut; its hue is that of the robots that saw it, and robots'
// ways are drawn on top, from a ring at the start to a disc at the end. Not thread safe.
class TopDownPicture {
 public:
  // Robots are counted as in MapPoint::robot. InvalidArgument for an extent that is empty, not
  // finite or without area, and for an impossible size.
  static absl::StatusOr<TopDownPicture> Create(const Box& extent,
                                               const std::vector<std::string>& robots,
                                               const PictureOptions& options = {});

  void Add(const std::vector<MapPoint>& points);
  // Poses T_map_sensor; what is not finite is left out.
  void AddTrajectory(uint32_t robot, Trajectory trajectory);

  // A closed line through these points of the map, drawn above all else. Named in the legend are
  // robots alone.
  void AddOutline(std::vector<Eigen::Vector2d> corners, Color color);

  // The size of the map, without the legend.
  int width() const { return width_; }
  int height() const { return height_; }
  double meters_per_pixel() const { return meters_per_pixel_; }
  // The picture's place in the map for GIS and CAD programs, as six lines of text (ESRI's world
  // file): metres per pixel along x, two turns, and along y, x and y of the first pixel's middle.
  std::string WorldFile() const;
  // The colour that stands for a robot.
  Color RobotColor(uint32_t robot) const;

  Canvas Draw() const;
  // ResourceExhausted when the disk is full; NotFound or PermissionDenied if it cannot be written.
  absl::Status WritePng(const std::string& path) const;

 private:
  TopDownPicture(const Box& extent, const std::vector<std::string>& robots,
                 const PictureOptions& options);
  void DrawGrid(Canvas& canvas) const;
  void DrawOrigin(Canvas& canvas) const;
  void DrawPoints(Canvas& canvas) const;
  void DrawTrajectories(Canvas& canvas) const;
  void DrawOutlines(Canvas& canvas) const;
  // The scale bar, then the names, in rows from y = `top` downwards; returns where they end.
  // Without a canvas nothing is drawn.
  int DrawLegend(int top, Canvas* canvas) const;
  double PixelX(double x) const { return (x - extent_.min.x()) / meters_per_pixel_; }
  double PixelY(double y) const { return (extent_.max.y() - y) / meters_per_pixel_; }

  Box extent_;
  std::vector<std::string> robots_;
  PictureOptions options_;
  double meters_per_pixel_;
  int width_, height_;
  // For every robot, and every pixel by row: a bit for each height (modulo 32 steps of 0.25 m)
  // with a point in it.
  std::vector<std::vector<uint32_t>> heights_;
  std::vector<std::pair<uint32_t, Trajectory>> trajectories_;
  std::vector<std::pair<std::vector<Eigen::Vector2d>, Color>> outlines_;
};

// The box that holds all trajectories and all but the outermost `outliers` share of the points on
// every side, and a margin of 2 %: what is worth showing of a map whose farthest points are few.
Box PictureExtent(const std::vector<MapPoint>& points, const std::vector<Trajectory>& trajectories,
                  double outliers = 0.002);

// "map.pgw" for "map.png".
std::string WorldFilePath(const std::string& picture);

// All in one: trajectory i is robot i's. With `world_file` there is one beside it.
absl::Status WritePicture(const std::string& path, const std::vector<MapPoint>& points,
                          const std::vector<Trajectory>& trajectories,
                          const std::vector<std::string>& robots,
                          const PictureOptions& options = {}, bool world_file = false);

}  // namespace isthmus::evaluation
