#include "lab/bench/rooms/plan_images.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/strip.h>
#include <png.h>

#include <algorithm>
#include <filesystem>
#include <set>

namespace isthmus::bench {
namespace {

constexpr double kCellM = 0.05;     // All plans have it.
constexpr uint8_t kWhite = 250;     // At least; lines' edges are grey.
constexpr double kLeastRoomM2 = 1;  // Less is left over between lines.
constexpr double kShortestDoorM = 0.4, kLongestDoorM = 2.5;
constexpr int64_t kLineCells = 3;  // From a door's line to the rooms that it parts.

// The image's grey values, the lowest row first.
absl::StatusOr<floors::GridMap> ReadGrid(const std::string& name) {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  if (png_image_begin_read_from_file(&image, name.c_str()) == 0) {
    return absl::InvalidArgumentError(absl::StrCat(name, ": ", image.message));
  }
  image.format = PNG_FORMAT_GRAY;
  std::vector<uint8_t> grey(PNG_IMAGE_SIZE(image));
  const png_color black = {0, 0, 0};
  if (png_image_finish_read(&image, &black, grey.data(), 0, nullptr) == 0) {
    return absl::InvalidArgumentError(absl::StrCat(name, ": ", image.message));
  }
  floors::GridMap map{
      .resolution_m = kCellM, .width = image.width, .height = image.height, .cells = {}};
  for (int64_t y = map.height; y-- > 0;) {
    for (int64_t x = 0; x < map.width; ++x) {
      map.cells.push_back(grey[static_cast<size_t>(y * map.width + x)] >= kWhite
                              ? floors::GridCell::kFree
                              : floors::GridCell::kOccupied);
    }
  }
  return map;
}

// Cells of one kind that hang together, each with those beside or, `across`, at corners too.
std::vector<std::vector<size_t>> Pieces(const floors::GridMap& map, std::vector<uint8_t> in,
                                        bool across) {
  std::vector<std::vector<size_t>> pieces;
  for (size_t first = 0; first < in.size(); ++first) {
    if (in[first] == 0) continue;
    std::vector<size_t> piece{first};
    in[first] = 0;
    for (size_t next = 0; next < piece.size(); ++next) {
      const auto x = static_cast<int64_t>(piece[next]) % map.width;
      const auto y = static_cast<int64_t>(piece[next]) / map.width;
      for (int64_t v = std::max<int64_t>(y - 1, 0); v <= std::min(y + 1, map.height - 1); ++v) {
        for (int64_t u = std::max<int64_t>(x - 1, 0); u <= std::min(x + 1, map.width - 1); ++u) {
          const auto at = static_cast<size_t>(v * map.width + u);
          if (in[at] == 0 || (!across && u != x && v != y)) continue;
          in[at] = 0;
          piece.push_back(at);
        }
      }
    }
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

bool IsFree(const floors::GridMap& map, size_t cell) {
  return map.cells[cell] == floors::GridCell::kFree;
}

void LabelRooms(const floors::GridMap& lined, TrueRooms* truth) {
  truth->labels.assign(lined.cells.size(), -1);
  std::vector<uint8_t> white;
  for (size_t i = 0; i < lined.cells.size(); ++i) white.push_back(IsFree(lined, i) ? 1 : 0);
  int32_t rooms = 0;
  for (const auto& piece : Pieces(lined, std::move(white), false)) {
    if (static_cast<double>(piece.size()) * kCellM * kCellM < kLeastRoomM2) continue;
    for (const size_t cell : piece) truth->labels[cell] = rooms;
    ++rooms;
  }
}

// The rooms near cells.
std::set<int32_t> RoomsNear(const floors::GridMap& map, const std::vector<size_t>& cells,
                            const TrueRooms& truth) {
  std::set<int32_t> rooms;
  for (const size_t cell : cells) {
    const auto x = static_cast<int64_t>(cell) % map.width;
    const auto y = static_cast<int64_t>(cell) / map.width;
    for (int64_t v = y - kLineCells; v <= y + kLineCells; ++v) {
      for (int64_t u = x - kLineCells; u <= x + kLineCells; ++u) {
        if (u < 0 || v < 0 || u >= map.width || v >= map.height) continue;
        const int32_t room = truth.labels[static_cast<size_t>(v * map.width + u)];
        if (room >= 0) rooms.insert(room);
      }
    }
  }
  return rooms;
}

void FindDoors(const floors::GridMap& bare, const floors::GridMap& lined, TrueRooms* truth) {
  std::vector<uint8_t> line;
  for (size_t i = 0; i < bare.cells.size(); ++i) {
    line.push_back(IsFree(bare, i) && !IsFree(lined, i) ? 1 : 0);
  }
  for (const auto& piece : Pieces(bare, std::move(line), true)) {
    Eigen::Array2d low = Eigen::Array2d::Constant(1e9), high = -low;
    for (const size_t cell : piece) {
      const int64_t x = static_cast<int64_t>(cell) % bare.width;
      const int64_t y = static_cast<int64_t>(cell) / bare.width;
      const Eigen::Array2d at(static_cast<double>(x), static_cast<double>(y));
      low = low.min(at), high = high.max(at + 1);
    }
    const double length_m = kCellM * (high - low).matrix().norm();
    if (length_m < kShortestDoorM || length_m > kLongestDoorM) continue;
    if (RoomsNear(bare, piece, *truth).size() < 2) continue;
    truth->doors.push_back(bare.origin + kCellM * ((low + high) / 2).matrix());
  }
}

}  // namespace

std::vector<std::string> PlansIn(const std::string& folder) {
  std::set<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    absl::string_view plan = name;
    if (absl::ConsumeSuffix(&plan, "_gt_segmentation.png")) names.insert(std::string(plan));
  }
  return {names.begin(), names.end()};
}

absl::StatusOr<PlanImages> ReadPlan(const std::string& folder, const std::string& name) {
  const auto read = [&](const std::string& ending) {
    return ReadGrid((std::filesystem::path(folder) / absl::StrCat(name, ending, ".png")).string());
  };
  auto bare = read(""), furnished = read("_furnitures"), lined = read("_gt_segmentation");
  for (const auto* map : {&bare, &furnished, &lined}) {
    if (!map->ok()) return map->status();
    if ((*map)->width != bare->width || (*map)->height != bare->height) {
      return absl::InvalidArgumentError(absl::StrCat(name, ": its images differ in size"));
    }
  }
  PlanImages plan{name, *std::move(bare), *std::move(furnished), {}};
  LabelRooms(*lined, &plan.truth);
  FindDoors(plan.bare, *lined, &plan.truth);
  return plan;
}

}  // namespace isthmus::bench
