// The figures of an evaluation.
#pragma once

#include <vector>

#include "client/evaluation/evaluation.h"
#include "client/report/figures.h"
#include "client/report/timing_file.h"

namespace isthmus::report {

// "trajectories": estimates on the truth from above; "error": position and rotation over the
// distance driven; "rpe": boxes by length of segment, unless no drive is long enough; "timing":
// stages scan by scan, if there are any. `camera_frame`: from above are x and z, as in KITTI's
// files, else x and y.
std::vector<Figure> FiguresOf(const evaluation::Evaluation& evaluation, bool camera_frame,
                              const std::vector<TimingFile>& timing);

// Every n-th value, at most kFigurePoints and the last.
std::vector<double> Thinned(const std::vector<double>& values, size_t most);

}  // namespace isthmus::report
