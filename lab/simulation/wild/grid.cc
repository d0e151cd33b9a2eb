#include <algorithm>

#include "lab/simulation/wild/scenes.h"

namespace isthmus::simulation::wild {

std::vector<Eigen::Vector3d> WalkOnGrid(
    int columns, int rows, double path_length_m,
    const std::function<Eigen::Vector3d(int column, int row)>& at, Random& random) {
  constexpr int kAhead[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  int column = random.Index(columns), row = random.Index(rows), heading = random.Index(4);
  std::vector<Eigen::Vector3d> corners{at(column, row)};
  double path_length = 0;
  while (path_length < path_length_m) {
    std::vector<int> ways;
    for (const int turn : {0, 0, 0, 1, 3}) {  // Straight on is likelier.
      const int to = (heading + turn) % 4;
      const int c = column + kAhead[to][0], r = row + kAhead[to][1];
      if (c >= 0 && c < columns && r >= 0 && r < rows) ways.push_back(to);
    }
    if (ways.empty()) ways.push_back((heading + 2) % 4);
    heading = ways[random.Index(static_cast<int>(ways.size()))];
    column += kAhead[heading][0];
    row += kAhead[heading][1];
    corners.push_back(at(column, row));
    path_length += (corners.back() - corners[corners.size() - 2]).norm();
  }
  return corners;
}

std::shared_ptr<Path> WalkAmong(const Blocks& blocks, const Need& need, Random& random) {
  const Eigen::Vector2d room =
      0.8 * (blocks.aisle.array() / 2 - need.clear_m() - 0.15).max(0.0).matrix();
  const auto corners = WalkOnGrid(
      blocks.columns + 1, blocks.rows + 1, need.path_length_m + 30,
      [&](int column, int row) -> Eigen::Vector3d {
        const double x = blocks.Pitch().x() * column + random.Uniform(-1, 1) * room.x();
        return {x, blocks.Pitch().y() * row + random.Uniform(-1, 1) * room.y(), 0};
      },
      random);
  return std::make_shared<Path>(
      Path::Along(corners, std::clamp(blocks.aisle.minCoeff() / 2.5, 0.7, 3.0)));
}

}  // namespace isthmus::simulation::wild
