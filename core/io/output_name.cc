#include "core/io/output_name.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <filesystem>

namespace isthmus::io {

std::string OutputExtension(const std::string& path) {
  const std::string end = absl::AsciiStrToLower(std::filesystem::path(path).extension().string());
  return std::any_of(end.begin(), end.end(), absl::ascii_isalpha) ? end : "";
}

absl::Status CheckOutputName(const std::string& path, const std::vector<std::string>& extensions) {
  const std::string end = OutputExtension(path);
  if (end.empty() || std::find(extensions.begin(), extensions.end(), end) != extensions.end()) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat(path, " would not hold what ", end, " files do: give it a name in ",
                   absl::StrJoin(extensions, " or "), ", or with no extension"));
}

}  // namespace isthmus::io
