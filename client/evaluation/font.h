// Letters, digits and some signs, 5 x 7 dots each.
#pragma once

#include <array>

namespace isthmus::evaluation {

inline constexpr int kGlyphWidth = 5, kGlyphHeight = 7;
using Glyph = std::array<const char*, kGlyphHeight>;  // '#' where there is a dot.

// Blank for a character the font has not.
const Glyph& FindGlyph(char character);

}  // namespace isthmus::evaluation
