#include "core/floors/outline.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/floors/simplify.h"

namespace isthmus::floors {
namespace {

constexpr std::array<Cell, 4> kAhead = {Cell{1, 0}, Cell{0, 1}, Cell{-1, 0}, Cell{0, -1}};

Eigen::Vector2d Along(size_t heading) {
  return {static_cast<double>(kAhead[heading].x), static_cast<double>(kAhead[heading].y)};
}

// Follows edges of cells with a label on their left.
class Tracer {
 public:
  Tracer(const Mask& ground, const std::vector<int32_t>& labels)
      : ground_(ground), labels_(labels), lower_seen_(labels.size()) {}

  // True if the lower edge of a cell bounds its label, and was not followed yet.
  bool IsNew(const Cell& cell) const {
    const size_t at = ground_.Index(cell.x, cell.y);
    return labels_[at] >= 0 && lower_seen_[at] == 0 && LabelAt(cell.x, cell.y - 1) != labels_[at];
  }

  // The corners of the outline with the lower edge of that cell.
  Outline Follow(const Cell& begin) {
    Outline outline;
    const int32_t label = LabelAt(begin.x, begin.y);
    Cell at = begin;
    size_t heading = 0;
    do {
      if (heading == 0) lower_seen_[ground_.Index(at.x, at.y)] = 1;
      at = {at.x + kAhead[heading].x, at.y + kAhead[heading].y};
      Turn(label, at, &heading, &outline);
    } while (at.x != begin.x || at.y != begin.y || heading != 0);
    return outline;
  }

 private:
  int32_t LabelAt(int64_t x, int64_t y) const {
    return ground_.Has(x, y) ? labels_[ground_.Index(x, y)] : -1;
  }
  // The cell that lies ahead of a corner, on its left or right.
  bool Has(int32_t label, const Cell& corner, size_t heading, bool is_left) const {
    constexpr std::array<Cell, 4> kLeft = {Cell{0, 0}, Cell{-1, 0}, Cell{-1, -1}, Cell{0, -1}};
    const Cell& off = kLeft[is_left ? heading : (heading + 3) % 4];
    return LabelAt(corner.x + off.x, corner.y + off.y) == label;
  }

  void Turn(int32_t label, const Cell& at, size_t* heading, Outline* outline) const {
    const bool left = Has(label, at, *heading, true), right = Has(label, at, *heading, false);
    if (left && !right) return;
    Eigen::Vector2d corner(static_cast<double>(at.x), static_cast<double>(at.y));
    const size_t turned = left ? (*heading + 3) % 4 : (*heading + 1) % 4;
    // Two cells that touch at this corner only: the outline keeps off it, on the side of each.
    if (!left && right) corner += (Along(turned) - Along(*heading)) / 4;
    outline->push_back(corner);
    *heading = turned;
  }

  const Mask& ground_;
  const std::vector<int32_t>& labels_;
  std::vector<uint8_t> lower_seen_;
};

}  // namespace

double SignedArea(const Outline& outline) {
  double twice = 0;
  for (size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2;
}

std::vector<std::vector<Outline>> OutlinesOf(const Mask& ground, const std::vector<int32_t>& labels,
                                             size_t count) {
  std::vector<std::vector<Outline>> outlines(count);
  Tracer tracer(ground, labels);
  for (size_t i = 0; i < labels.size(); ++i) {
    const Cell at = ground.At(i);
    if (tracer.IsNew(at)) {
      outlines[static_cast<size_t>(labels[i])].push_back(tracer.Follow(at));
    }
  }
  for (std::vector<Outline>& each : outlines) {
    std::stable_partition(each.begin(), each.end(),
                          [](const Outline& outline) { return SignedArea(outline) > 0; });
    Simplify(&each);
  }
  return outlines;
}

}  // namespace isthmus::floors
