// Regions, tiles and exports of a map of a hundred million points that is larger than its memory.
// See lab/docs/large_map.md.
#include <absl/strings/str_format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/stopwatch.h"
#include "lab/bench/large_map/city.h"
#include "lab/bench/memory.h"
#include "lab/bench/merging/temporary_folder.h"
#include "server/composition/composer.h"
#include "server/query/export.h"

namespace isthmus::bench {
namespace {

using composition::Composer;
using composition::ComposerOptions;

constexpr size_t kChunk = 50'000;  // Points; as the RPC.

struct Arguments {
  double million_points = 100;
  int cache_mb = 512;  // The server's, of which composition has three eighths.
  int queries = 400;
  unsigned seed = 1;
};

// A street of a campus, drawn once, and copies of it side by side. Nothing is stored: a copy's
// points are those of the original.
class Campus {
 public:
  static constexpr int kSubmaps = 12;                     // Per street.
  static constexpr double kAlongM = 400, kAcrossM = 220;  // From copy to copy; they do not touch.

  explicit Campus(unsigned seed) {
    const City city({.points = 30'000});
    std::mt19937 rng(seed);
    for (int s = 0; s < kSubmaps; ++s) {
      Submap submap = city.Drive(s * city.submap_length_m(), -3, &rng);
      T_street_submap_.push_back(submap.T_odom_submap);
      Thin(&submap);
      street_.push_back(std::move(submap));
    }
  }

  std::vector<PlacedSubmap> Copies(int count) const {
    const int columns = std::max(1, static_cast<int>(std::sqrt(count * kAcrossM / kAlongM)));
    std::vector<PlacedSubmap> placed;
    for (int copy = 0; copy < count; ++copy) {
      const int row = copy / columns;
      const Pose T_map_street(Eigen::Vector3d(copy % columns * kAlongM, row * kAcrossM, 0));
      for (int s = 0; s < kSubmaps; ++s) {
        SubmapInfo info = Summarize(street_[s]);
        info.id = {SessionId("alice-1"), static_cast<uint32_t>(copy * kSubmaps + s)};
        placed.push_back(
            {std::make_shared<SubmapInfo>(info), 0, T_map_street * T_street_submap_[s]});
      }
    }
    return placed;
  }
  SubmapReader reader() const {
    return [this](const SubmapId& id) {
      auto submap = std::make_shared<Submap>(street_[id.index % kSubmaps]);
      submap->id = id;
      return submap;
    };
  }

 private:
  // To what composition keeps, so that drawing them is the only long wait.
  static void Thin(Submap* submap) {
    std::set<std::tuple<int, int, int>> seen;
    std::erase_if(submap->points, [&](const SubmapPoint& p) {
      const auto index = [](float at) { return static_cast<int>(std::floor(at * 10)); };
      return !seen.emplace(index(p.x), index(p.y), index(p.z)).second;
    });
    submap->robot = RobotId("alice");
  }

  std::vector<Submap> street_;
  std::vector<Pose> T_street_submap_;
};

struct Times {
  std::vector<double> ms;

  double Quantile(double share) {
    std::sort(ms.begin(), ms.end());
    return ms[static_cast<size_t>(share * static_cast<double>(ms.size() - 1))];
  }
};

// Boxes of this edge at 0.1 m, half of a street's width above the ground and below.
std::vector<Region> RandomBoxes(const std::vector<PlacedSubmap>& placed, double edge_m, int count,
                                std::mt19937* rng) {
  std::uniform_real_distribution<double> offset(-20, 20);
  std::vector<Region> boxes;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d center =
        placed[(*rng)() % placed.size()].T_map_submap.translation() +
        Eigen::Vector3d(offset(*rng), edge_m < 10 ? offset(*rng) / 3 : offset(*rng), 0);
    Region& box = boxes.emplace_back();
    box.box.Extend(center - Eigen::Vector3d::Constant(edge_m / 2));
    box.box.Extend(center + Eigen::Vector3d::Constant(edge_m / 2));
    box.resolution_m = 0.1;
  }
  return boxes;
}

// Milliseconds to the first chunk, and the number of points.
absl::StatusOr<std::pair<double, double>> ReadBox(const ComposedMap& map, const Region& box) {
  const Stopwatch watch;
  double first_ms = -1, points = 0;
  const absl::Status status = map.Read(box, kChunk, [&](const std::vector<MapPoint>& chunk) {
    if (first_ms < 0) first_ms = watch.Ms();
    points += static_cast<double>(chunk.size());
    return true;
  });
  if (!status.ok()) return status;
  return std::pair(first_ms < 0 ? watch.Ms() : first_ms, points);
}

absl::Status MeasureBoxes(const ComposedMap& map, const std::vector<PlacedSubmap>& placed,
                          const Arguments& arguments) {
  std::mt19937 rng(arguments.seed);
  Times first, whole;
  double points = 0;
  for (const Region& box : RandomBoxes(placed, 30, arguments.queries, &rng)) {
    const Stopwatch watch;
    const auto read = ReadBox(map, box);
    if (!read.ok()) return read.status();
    whole.ms.push_back(watch.Ms());
    first.ms.push_back(read->first);
    points += read->second;
  }
  absl::PrintF(
      "30 m box at 0.1 m: %.0f points; first chunk p50 %.1f p99 %.1f ms; "
      "whole p50 %.1f p99 %.1f ms\n",
      points / arguments.queries, first.Quantile(.5), first.Quantile(.99), whole.Quantile(.5),
      whole.Quantile(.99));
  const std::vector<Region> small = RandomBoxes(placed, 5, 20, &rng);
  double read_boxes = 0;
  points = 0;
  const Stopwatch watch;
  for (; watch.Ms() < 3000; ++read_boxes) {
    const auto read = ReadBox(map, small[static_cast<size_t>(read_boxes) % small.size()]);
    if (!read.ok()) return read.status();
    points += read->second;
  }
  absl::PrintF("5 m box in memory: %.0f points; %.0f a second\n", points / read_boxes,
               read_boxes / watch.Ms() * 1e3);
  return absl::OkStatus();
}

absl::Status MeasureTiles(const ComposedMap& map, const Arguments& arguments) {
  std::mt19937 rng(arguments.seed);
  for (uint32_t level = 0; level < map.tile_levels(0); ++level) {
    const std::vector<TileInfo> tiles = map.Tiles(0, level);
    Times times;
    double points = 0;
    const int count = std::min(static_cast<int>(tiles.size()), arguments.queries / 4);
    for (int i = 0; i < count; ++i) {
      const Stopwatch watch;
      const auto read = map.ReadTile(tiles[rng() % tiles.size()].id);
      if (!read.ok()) return read.status();
      times.ms.push_back(watch.Ms());
      points += static_cast<double>(read->size());
    }
    absl::PrintF("tiles of level %d: %d; %.0f points; p50 %.2f p99 %.1f ms\n", level, tiles.size(),
                 points / count, times.Quantile(.5), times.Quantile(.99));
  }
  return absl::OkStatus();
}

absl::Status MeasureExport(const ComposedMap& map) {
  double bytes = 0;
  const Stopwatch watch;
  const absl::Status status =
      query::ExportCloud(map, {}, query::CloudFormat::kPcdBinary, [&](const std::string& piece) {
        bytes += static_cast<double>(piece.size());
        return true;
      });
  absl::PrintF("PCD: %.0f MB at %.0f MB/s\n", bytes / 1e6, bytes / 1e3 / watch.Ms());
  return status;
}

absl::Status Run(const Arguments& arguments) {
  const TemporaryFolder folder;
  const Campus campus(arguments.seed);
  ComposerOptions options;
  double points_of_copy = 0;
  {
    Composer composer(options);
    const auto street = composer.Compose(1, campus.Copies(1), campus.reader());
    if (!street.ok()) return street.status();
    points_of_copy = static_cast<double>((*street)->point_count(0));
  }
  options.cache_bytes = (size_t(arguments.cache_mb) << 20) * 3 / 8;
  options.folder = folder.path();
  const int copies = static_cast<int>(std::ceil(arguments.million_points * 1e6 / points_of_copy));
  const std::vector<PlacedSubmap> placed = campus.Copies(copies);
  Composer composer(options);
  const double before_mb = ResidentMb();
  const Stopwatch watch;
  const auto map = composer.Compose(1, placed, campus.reader());
  if (!map.ok()) return map.status();
  absl::PrintF(
      "%.1f M points on %d tiles of %d submaps, composed in %.1f s; %.0f MB in the file, "
      "%.0f MB of RAM, %.0f before\n",
      (*map)->point_count(0) / 1e6, (*map)->Tiles(0, 0).size(), placed.size(), watch.Ms() / 1e3,
      composer.memory().spilled_bytes / 1e6, ResidentMb(), before_mb);
  ResetPeak();
  absl::Status status = MeasureBoxes(**map, placed, arguments);
  if (status.ok()) status = MeasureTiles(**map, arguments);
  if (status.ok()) status = MeasureExport(**map);
  absl::PrintF("%.0f MB of RAM at most\n", PeakMb());
  return status;
}

}  // namespace
}  // namespace isthmus::bench

int main(int argc, char** argv) {
  isthmus::bench::Arguments arguments;
  CLI::App app("Composes a campus out of copies of a street, and reads boxes, tiles and a file.");
  app.add_option("--million-points", arguments.million_points, "Of the map")->capture_default_str();
  app.add_option("--cache-mb", arguments.cache_mb, "The server's cache")->capture_default_str();
  app.add_option("--queries", arguments.queries, "Boxes to read")
      ->capture_default_str()
      ->check(CLI::Range(4, 1'000'000));
  app.add_option("--seed", arguments.seed, "Of points and boxes")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = isthmus::bench::Run(arguments);
  if (!status.ok()) absl::FPrintF(stderr, "%s\n", status.ToString());
  return status.ok() ? 0 : 1;
}
