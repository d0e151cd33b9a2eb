// Limits of what figures and pages show.
#pragma once

#include <cstddef>

namespace isthmus::report {

// Points of a line in a figure: a thousand pixels show no more. Lines with more are thinned, their
// last point is kept.
inline constexpr size_t kFigurePoints = 3000;

// Values per box of a boxplot: more change its quartiles by less than a line's width.
inline constexpr size_t kBoxValues = 2000;

// Pixels of the longer side of a map on a page: twice what a page is wide, for sharp screens.
inline constexpr int kMapSidePx = 1400;

// Maps on a page, the largest first: a server may have as many as sessions, most of them small.
inline constexpr size_t kMostMaps = 4;

// Revisions on a page, the newest first: what somebody reads who asks what has just happened.
inline constexpr int kMostRevisions = 20;

// Sessions and matches that a figure of the match graph, and rows that a table of a page may have:
// more cannot be read. `isthmus graph` has all.
inline constexpr size_t kGraphSessions = 48;
inline constexpr size_t kMostRows = 200;

// Bytes of a cell from which on its column is kept wide enough to be read: a sentence, not a name.
inline constexpr size_t kLongCell = 40;

}  // namespace isthmus::report
