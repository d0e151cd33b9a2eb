// An RGB image to draw on.
#pragma once

#include <absl/status/statusor.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace isthmus::evaluation {

using Color = std::array<uint8_t, 3>;  // Red, green, blue.

// Pixel (0, 0) is the upper left one; its middle has the coordinates (0, 0). What falls outside is
// not drawn. Not thread safe.
class Canvas {
 public:
  Canvas(int width, int height, Color background);

  int width() const { return width_; }
  int height() const { return height_; }
  Color At(int x, int y) const;
  // Mixes a pixel with `color`; opacity 1 replaces it.
  void Blend(int x, int y, Color color, double opacity);
  void Rectangle(int x0, int y0, int x1, int y1, Color color);  // Filled, both corners included.
  // Anti-aliased.
  void Line(double x0, double y0, double x1, double y1, double thickness, Color color);
  void Disc(double x, double y, double radius, Color color);
  // In letters of 5 x 7 dots of `scale` pixels; (x, y) is the upper left corner. What the font has
  // not (it has A-Z, a-z, 0-9 and . , : - + _ / ( ) %) is left blank.
  void Text(int x, int y, const std::string& text, int scale, Color color);
  static int TextWidth(const std::string& text, int scale);

  // Internal if the encoder fails.
  absl::StatusOr<std::string> EncodePng() const;

 private:
  int width_, height_;
  std::vector<uint8_t> pixels_;  // Rows of red, green, blue.
};

}  // namespace isthmus::evaluation
