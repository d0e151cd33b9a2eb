#include "core/site_name.h"

#include <absl/strings/ascii.h>
#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>

#include <algorithm>

namespace isthmus {

absl::Status CheckSiteName(const std::string& name) {
  constexpr size_t kLongest = 64;
  const bool is_good = !name.empty() && name.size() <= kLongest && name[0] != '.' &&
                       std::all_of(name.begin(), name.end(), [](char c) {
                         return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '_' ||
                                c == '.' || c == '-';
                       });
  if (is_good) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("\"", absl::CHexEscape(name),
                                                 "\" cannot name a site: give up to ", kLongest,
                                                 " of [A-Za-z0-9_.-], no dot in front"));
}

}  // namespace isthmus
