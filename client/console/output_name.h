// The check of names of output files, as options have it.
#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "core/io/output_name.h"

namespace isthmus::cli {

using io::CheckOutputName;
using io::OutputExtension;

// CheckOutputName of an option's value.
CLI::Validator OutputNamed(const std::vector<std::string>& extensions);

}  // namespace isthmus::cli
