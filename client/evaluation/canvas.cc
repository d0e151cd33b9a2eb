#include "client/evaluation/canvas.h"

#include <absl/strings/str_cat.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace isthmus::evaluation {
namespace {

constexpr int kGlyphWidth = 5, kGlyphHeight = 7;      // Layout
using Glyph = std::array<const char*, kGlyphHeight>;  // '#' where there is a dot.

struct Entry {
  char character;
  Glyph rows;
};

// Letters, digits and some signs.
// clang-format off
constexpr Entry kFont[] = {
      {'A', {".###.", "#...#", "#...#", "#####", "#...#", "#...#", "#...#"}},
      {'B', {"####.", "#...#", "#...#", "####.", "#...#", "#...#", "####."}},
      {'C', {".###.", "#...#", "#....", "#....", "#....", "#...#", ".###."}},
      {'D', {"####.", "#...#", "#...#", "#...#", "#...#", "#...#", "####."}},
      {'E', {"#####", "#....", "#....", "####.", "#....", "#....", "#####"}},
      {'F', {"#####", "#....", "#....", "####.", "#....", "#....", "#...."}},
      {'G', {".###.", "#...#", "#....", "#.###", "#...#", "#...#", ".####"}},
      {'H', {"#...#", "#...#", "#...#", "#####", "#...#", "#...#", "#...#"}},
      {'I', {".###.", "..#..", "..#..", "..#..", "..#..", "..#..", ".###."}},
      {'J', {"..###", "...#.", "...#.", "...#.", "...#.", "#..#.", ".##.."}},
      {'K', {"#...#", "#..#.", "#.#..", "##...", "#.#..", "#..#.", "#...#"}},
      {'L', {"#....", "#....", "#....", "#....", "#....", "#....", "#####"}},
      {'M', {"#...#", "##.##", "#.#.#", "#.#.#", "#...#", "#...#", "#...#"}},
      {'N', {"#...#", "##..#", "##..#", "#.#.#", "#..##", "#..##", "#...#"}},
      {'O', {".###.", "#...#", "#...#", "#...#", "#...#", "#...#", ".###."}},
      {'P', {"####.", "#...#", "#...#", "####.", "#....", "#....", "#...."}},
      {'Q', {".###.", "#...#", "#...#", "#...#", "#.#.#", "#..#.", ".##.#"}},
      {'R', {"####.", "#...#", "#...#", "####.", "#.#..", "#..#.", "#...#"}},
      {'S', {".####", "#....", "#....", ".###.", "....#", "....#", "####."}},
      {'T', {"#####", "..#..", "..#..", "..#..", "..#..", "..#..", "..#.."}},
      {'U', {"#...#", "#...#", "#...#", "#...#", "#...#", "#...#", ".###."}},
      {'V', {"#...#", "#...#", "#...#", "#...#", "#...#", ".#.#.", "..#.."}},
      {'W', {"#...#", "#...#", "#...#", "#.#.#", "#.#.#", "##.##", "#...#"}},
      {'X', {"#...#", "#...#", ".#.#.", "..#..", ".#.#.", "#...#", "#...#"}},
      {'Y', {"#...#", "#...#", ".#.#.", "..#..", "..#..", "..#..", "..#.."}},
      {'Z', {"#####", "....#", "...#.", "..#..", ".#...", "#....", "#####"}},
      {'a', {".....", ".....", ".###.", "....#", ".####", "#...#", ".####"}},
      {'b', {"#....", "#....", "####.", "#...#", "#...#", "#...#", "####."}},
      {'c', {".....", ".....", ".####", "#....", "#....", "#....", ".####"}},
      {'d', {"....#", "....#", ".####", "#...#", "#...#", "#...#", ".####"}},
      {'e', {".....", ".....", ".###.", "#...#", "#####", "#....", ".###."}},
      {'f', {"..##.", ".#...", "####.", ".#...", ".#...", ".#...", ".#..."}},
      {'g', {".....", ".####", "#...#", "#...#", ".####", "....#", ".###."}},
      {'h', {"#....", "#....", "####.", "#...#", "#...#", "#...#", "#...#"}},
      {'i', {"..#..", ".....", ".##..", "..#..", "..#..", "..#..", ".###."}},
      {'j', {"...#.", ".....", "..##.", "...#.", "...#.", "#..#.", ".##.."}},
      {'k', {"#....", "#....", "#..#.", "#.#..", "##...", "#.#..", "#..#."}},
      {'l', {".##..", "..#..", "..#..", "..#..", "..#..", "..#..", ".###."}},
      {'m', {".....", ".....", "##.#.", "#.#.#", "#.#.#", "#.#.#", "#.#.#"}},
      {'n', {".....", ".....", "####.", "#...#", "#...#", "#...#", "#...#"}},
      {'o', {".....", ".....", ".###.", "#...#", "#...#", "#...#", ".###."}},
      {'p', {".....", "####.", "#...#", "#...#", "####.", "#....", "#...."}},
      {'q', {".....", ".####", "#...#", "#...#", ".####", "....#", "....#"}},
      {'r', {".....", ".....", "#.##.", "##...", "#....", "#....", "#...."}},
      {'s', {".....", ".....", ".####", "#....", ".###.", "....#", "####."}},
      {'t', {".#...", ".#...", "####.", ".#...", ".#...", ".#...", "..##."}},
      {'u', {".....", ".....", "#...#", "#...#", "#...#", "#...#", ".####"}},
      {'v', {".....", ".....", "#...#", "#...#", "#...#", ".#.#.", "..#.."}},
      {'w', {".....", ".....", "#...#", "#.#.#", "#.#.#", "#.#.#", ".#.#."}},
      {'x', {".....", ".....", "#...#", ".#.#.", "..#..", ".#.#.", "#...#"}},
      {'y', {".....", "#...#", "#...#", "#...#", ".####", "....#", ".###."}},
      {'z', {".....", ".....", "#####", "...#.", "..#..", ".#...", "#####"}},
      {'0', {".###.", "#...#", "#..##", "#.#.#", "##..#", "#...#", ".###."}},
      {'1', {"..#..", ".##..", "..#..", "..#..", "..#..", "..#..", ".###."}},
      {'2', {".###.", "#...#", "....#", "..##.", ".#...", "#....", "#####"}},
      {'3', {"####.", "....#", "....#", ".###.", "....#", "....#", "####."}},
      {'4', {"...#.", "..##.", ".#.#.", "#..#.", "#####", "...#.", "...#."}},
      {'5', {"#####", "#....", "####.", "....#", "....#", "#...#", ".###."}},
      {'6', {".###.", "#....", "#....", "####.", "#...#", "#...#", ".###."}},
      {'7', {"#####", "....#", "...#.", "..#..", "..#..", ".#...", ".#..."}},
      {'8', {".###.", "#...#", "#...#", ".###.", "#...#", "#...#", ".###."}},
      {'9', {".###.", "#...#", "#...#", ".####", "....#", "....#", ".###."}},
      {'.', {".....", ".....", ".....", ".....", ".....", ".##..", ".##.."}},
      {',', {".....", ".....", ".....", ".....", ".##..", ".##..", ".#..."}},
      {':', {".....", ".##..", ".##..", ".....", ".##..", ".##..", "....."}},
      {'-', {".....", ".....", ".....", ".###.", ".....", ".....", "....."}},
      {'+', {".....", "..#..", "..#..", "#####", "..#..", "..#..", "....."}},
      {'_', {".....", ".....", ".....", ".....", ".....", ".....", "#####"}},
      {'/', {"....#", "....#", "...#.", "..#..", ".#...", "#....", "#...."}},
      {'(', {"...#.", "..#..", ".#...", ".#...", ".#...", "..#..", "...#."}},
      {')', {".#...", "..#..", "...#.", "...#.", "...#.", "..#..", ".#..."}},
      {'%', {"##..#", "##.#.", "...#.", "..#..", ".#...", ".#.##", "#..##"}},
};
// clang-format on

constexpr Glyph kBlank = {".....", ".....", ".....", ".....", ".....", ".....", "....."};

// Blank for a character the font has not.
const Glyph& FindGlyph(char character) {
  const auto entry = std::find_if(std::begin(kFont), std::end(kFont),
                                  [character](const Entry& e) { return e.character == character; });
  return entry == std::end(kFont) ? kBlank : entry->rows;
}

}  // namespace

Canvas::Canvas(int width, int height, Color background) : width_(width), height_(height) {
  pixels_.reserve(size_t{3} * width * height);
  for (int i = 0; i < width * height; ++i) {
    pixels_.insert(pixels_.end(), background.begin(), background.end());
  }
}

Color Canvas::At(int x, int y) const {
  const uint8_t* p = &pixels_[3 * (static_cast<size_t>(y) * width_ + x)];
  return {p[0], p[1], p[2]};
}

void Canvas::Blend(int x, int y, Color color, double opacity) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
  uint8_t* p = &pixels_[3 * (static_cast<size_t>(y) * width_ + x)];
  for (int i = 0; i < 3; ++i) {
    p[i] = static_cast<uint8_t>(std::lround(p[i] + opacity * (color[i] - p[i])));
  }
}

void Canvas::Rectangle(int x0, int y0, int x1, int y1, Color color) {
  for (int y = std::max(0, y0); y <= std::min(y1, height_ - 1); ++y) {
    for (int x = std::max(0, x0); x <= std::min(x1, width_ - 1); ++x) Blend(x, y, color, 1);
  }
}

void Canvas::Line(double x0, double y0, double x1, double y1, double thickness, Color color) {
  const double dx = x1 - x0, dy = y1 - y0, squared = dx * dx + dy * dy;
  const double reach = thickness / 2 + 1;
  const auto low = [&](double a, double b) {
    return static_cast<int>(std::floor(std::max(-1e6, std::min(a, b)) - reach));
  };
  const auto high = [&](double a, double b) {
    return static_cast<int>(std::ceil(std::min(1e6, std::max(a, b)) + reach));
  };
  for (int y = std::max(0, low(y0, y1)); y <= std::min(height_ - 1, high(y0, y1)); ++y) {
    for (int x = std::max(0, low(x0, x1)); x <= std::min(width_ - 1, high(x0, x1)); ++x) {
      double f = squared > 0 ? ((x - x0) * dx + (y - y0) * dy) / squared : 0;
      f = std::clamp(f, 0.0, 1.0);
      const double distance = std::hypot(x - x0 - f * dx, y - y0 - f * dy);
      const double covered = std::clamp(thickness / 2 + 0.5 - distance, 0.0, 1.0);
      if (covered > 0) Blend(x, y, color, covered);
    }
  }
}

void Canvas::Disc(double x, double y, double radius, Color color) {
  Line(x, y, x, y, 2 * radius, color);
}

void Canvas::Text(int x, int y, const std::string& text, int scale, Color color) {
  for (const char character : text) {
    const Glyph& glyph = FindGlyph(character);
    for (int row = 0; row < kGlyphHeight; ++row) {
      for (int column = 0; column < kGlyphWidth; ++column) {
        if (glyph[row][column] != '#') continue;
        const int left = x + column * scale, top = y + row * scale;
        Rectangle(left, top, left + scale - 1, top + scale - 1, color);
      }
    }
    x += (kGlyphWidth + 1) * scale;
  }
}

int Canvas::TextWidth(const std::string& text, int scale) {
  return static_cast<int>(text.size()) * (kGlyphWidth + 1) * scale;
}

absl::StatusOr<std::string> Canvas::EncodePng() const {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width_);
  image.height = static_cast<png_uint_32>(height_);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels_.data(), 0, nullptr) == 0) {
    const std::string reason = image.message;
    png_image_free(&image);
    return absl::InternalError(absl::StrCat("cannot encode a PNG image: ", reason));
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace isthmus::evaluation
