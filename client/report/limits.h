// Limits of what figures and pages show.
#pragma once

#include <cstddef>

namespace isthmus::report {

// Points of a line in a figure: a thousand pixels show no more. Lines with more are thinned, their
// last point is kept.
inline constexpr size_t kFigurePoints = 3000;

// Values per box of a boxplot: more change its quartiles by less than a line's width.
inline constexpr size_t kBoxValues = 2000;

}  // namespace isthmus::report
