// The text of figures.py, which the build puts into the programs.
#pragma once

namespace isthmus::report {

extern const char kFiguresScript[];

}  // namespace isthmus::report
