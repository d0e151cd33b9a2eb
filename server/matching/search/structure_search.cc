#include "server/matching/search/structure_search.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/stopwatch.h"
#include "server/matching/search/birds_eye.h"
#include "server/matching/search/birds_eye_grid.h"
#include "server/matching/search/limits.h"
#include "server/matching/search/planar_search.h"

namespace isthmus::matching {
namespace {

SceneScale ScaleOf(bool outdoors) {
  SceneScale scale;
  scale.outdoors = outdoors;
  scale.cell_m = outdoors ? kStructureCellOutdoorsM : kStructureCellM;
  const int layers = outdoors ? 32 : kLayersUnderRoof;
  scale.wall = {kLowestStructureM,
                kLowestStructureM + kStructureLayerM * static_cast<float>(layers)};
  scale.free = {0.4f, 2.5f};
  scale.max_range_m = outdoors ? kStructureRangeOutdoorsM : kStructureRangeM;
  return scale;
}

// The weight of a column of space: low things, things of a person's height, high things, and an
// upright column add to it.
float Weigh(uint32_t layers) {
  const auto filled = [&](uint32_t mask, float all) {
    return std::min(1.0f, static_cast<float>(std::popcount(layers & mask)) / all);
  };
  if (layers == 0) return 0;
  const int reach = 31 - std::countl_zero(layers) - std::countr_zero(layers);
  const bool upright = reach >= 3 && std::popcount(layers) >= 3;
  return 0.5f * (filled(0x1Fu, 2) + filled(0x3FFu << 5, 3) + filled(~0u << 15, 4) +
                 (upright ? 1.0f : 0.0f));
}

BirdsEyeImage MakeImage(const BirdsEyeCells& cells) {
  BirdsEyeImage image;
  image.cell_m = static_cast<float>(cells.cell_m);
  image.origin = cells.center.array() - cells.radius - 2 * image.cell_m;
  image.width = image.rows = static_cast<int>(2 * cells.radius / image.cell_m) + 5;
  for (auto& plane : image.planes) {
    plane.assign(static_cast<size_t>(image.width) * image.rows, 0.0f);
  }
  const auto index = [&](const Eigen::Vector2f& p) {
    const Eigen::Vector2f at = (p - image.origin) / image.cell_m;
    return static_cast<size_t>(CellAt(at.y(), image.rows)) * image.width +
           CellAt(at.x(), image.width);
  };
  for (const auto& wall : cells.walls) {
    const size_t i = index(wall.position);
    image.planes[BirdsEyeImage::kNormalX][i] = wall.normal.x();
    image.planes[BirdsEyeImage::kNormalY][i] = wall.normal.y();
    image.planes[BirdsEyeImage::kWall][i] = wall.weight;
    image.planes[BirdsEyeImage::kFree][i] = -kStructureFreeWeight * wall.weight;
  }
  for (const auto& p : cells.free) {
    image.planes[BirdsEyeImage::kWall][index(p)] -= kStructureFreeWeight;
  }
  for (auto& plane : image.planes) Blur(image.width, image.rows, &plane);
  return image;
}

}  // namespace

std::vector<Candidate> SearchStructure(const WallMap& a, const WallMap& b, std::stop_token stop,
                                       std::vector<StageTime>* stages) {
  const Stopwatch watch;
  const bool outdoors = PairScale(a, b).outdoors;
  const double cell = CellThatFits(a, b, ScaleOf(outdoors), ScaleOf(outdoors).cell_m);
  const BirdsEyeCells a_cells = MakeStructureCells(a, outdoors, cell);
  const BirdsEyeCells b_cells = MakeStructureCells(b, outdoors, cell);
  std::vector<Candidate> candidates;
  if (!a_cells.walls.empty() && !b_cells.walls.empty()) {
    PlanarSearchOptions options;
    options.whiten = true;
    options.stop = std::move(stop);
    const std::vector<PlanarPose> poses = SuppressNeighbors(
        SearchPlanar(MakeImage(a_cells), b_cells, options), b_cells.center.cast<double>(), 4 * cell,
        kSuppressYawRad, kStructureCandidates);
    for (const PlanarPose& pose : poses) {
      if (pose.score < kMinStructureShare * poses.front().score) break;
      candidates.push_back(ToCandidate(a, b, pose, GuessSource::kStructure));
    }
  }
  if (stages) stages->push_back({"structure", watch.Ms()});
  return candidates;
}

BirdsEyeCells MakeStructureCells(const WallMap& map, bool outdoors, double cell_m) {
  const SceneScale scale = ScaleOf(outdoors);
  BirdsEyeCells cells;
  cells.cell_m = cell_m;
  const BirdsEyeGrid grid = MakeBirdsEyeGrid(map, scale, cell_m);
  if (grid.width == 0) return cells;
  std::vector<BirdsEyeColumn> columns = CollectWalls(map, scale, grid);
  for (BirdsEyeColumn& column : columns) column.layers = 0;
  map.VisitEnds([&](const Eigen::Vector2f& at, float height, float range) {
    if (!(height >= scale.wall.low && height < scale.wall.high && range < scale.max_range_m))
      return;
    const int i = grid.Index(at);
    if (i >= 0)
      columns[i].layers |= 1u << static_cast<int>((height - scale.wall.low) / kStructureLayerM);
  });
  const std::vector<uint8_t> hits = CollectFree(map, scale, grid);
  for (size_t i = 0; i < grid.size(); ++i) {
    const BirdsEyeColumn& column = columns[i];
    const Eigen::Vector2f center = grid.Center(static_cast<int>(i));
    if (column.layers != 0 || column.count > 0) {
      const auto count = static_cast<float>(std::max(column.count, 1));
      cells.walls.push_back({center, column.normal / count, Weigh(column.layers)});
    } else if (hits[i] >= 2) {
      cells.free.push_back(center);
    }
  }
  cells.Enclose();
  return cells;
}

}  // namespace isthmus::matching
