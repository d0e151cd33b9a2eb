// Figures as SVG and PNG, drawn by Matplotlib.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <string>
#include <vector>

#include "client/console/json.h"

namespace isthmus::report {

// A figure: "file" (its name without the ending), "kind" and "title", and what figures.py takes for
// that kind.
using Figure = cli::Json;

// Writes FILE.svg and FILE.png for every figure to `folder`, which is made where it is missing, and
// beside them figures.json and figures.py, which draw them again once a person has changed them.
// Runs python3: /usr/bin/python3 if there is one, else the first in PATH; the environment's
// ISTHMUS_PYTHON is taken before both. FailedPrecondition, naming the package to install, where
// Python or Matplotlib is missing; Internal with what Python said where it fails.
absl::Status DrawFigures(const std::string& folder, const std::vector<Figure>& figures);

// The SVG file of a figure that was drawn, as part of a page: without its head, its ids beginning
// with `file`, its text in the page's colour and its ground left to the page.
absl::StatusOr<std::string> InlineSvg(const std::string& folder, const std::string& file);

}  // namespace isthmus::report
