// The names that output files may have: an extension tells what is in a file, so it must be true.
#pragma once

#include <absl/status/status.h>

#include <string>
#include <vector>

namespace isthmus::io {

// ".las" of "a/MAP.LAS". Empty where there is none: for streams (output_file.h) and names whose end
// has no letter, a date for one.
std::string OutputExtension(const std::string& path);

// InvalidArgument, naming those that would do, where the path has an extension that is none of
// these (".las", in small letters).
absl::Status CheckOutputName(const std::string& path, const std::vector<std::string>& extensions);

}  // namespace isthmus::io
