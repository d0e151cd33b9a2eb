#include "core/map/point_class.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <array>
#include <string>

namespace isthmus {
namespace {

// By number.
constexpr std::array<const char*, kPointClasses> kPointClassNames = {
    "unknown",    "ground",  "ceiling", "wall",      "pole",
    "vegetation", "vehicle", "object",  "structure", "mover"};

}  // namespace

const char* ToString(PointClass point_class) {
  const auto number = static_cast<size_t>(point_class);
  return number < kPointClassNames.size() ? kPointClassNames[number] : "unknown";
}

absl::StatusOr<PointClass> ParsePointClass(std::string_view name) {
  for (size_t i = 0; i < kPointClassNames.size(); ++i) {
    if (name == kPointClassNames[i]) return static_cast<PointClass>(i);
  }
  return absl::InvalidArgumentError(absl::StrCat("no class of points is called \"",
                                                 std::string(name), "\"; choose one of ",
                                                 absl::StrJoin(kPointClassNames, ", ")));
}

}  // namespace isthmus
