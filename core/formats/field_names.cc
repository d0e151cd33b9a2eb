#include "core/formats/field_names.h"

#include <absl/strings/ascii.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/strip.h>

namespace isthmus::formats {
namespace {

// VeloView's and ParaView's "Points:0", with or without a unit.
absl::string_view AxisOfTuple(absl::string_view lower) {
  if (!absl::StartsWith(lower, "points") || lower.size() < 2) return {};
  const absl::string_view end = lower.substr(lower.size() - 2);
  return end == ":0" ? "x" : end == ":1" ? "y" : end == ":2" ? "z" : "";
}

// Takes a unit off the end, "x (mm)", "x[m]", "x_mm"; returns metres per unit.
double TakeUnit(std::string& name) {
  const struct {
    const char* text;
    double scale;
  } units[] = {{"mm", 1e-3}, {"cm", 1e-2}, {"m", 1}};
  for (const auto& unit : units) {
    for (const std::string& end :
         {absl::StrCat("(", unit.text, ")"), absl::StrCat("[", unit.text, "]"),
          absl::StrCat("_", unit.text)}) {
      absl::string_view left = name;
      if (!absl::ConsumeSuffix(&left, end)) continue;
      left = absl::StripAsciiWhitespace(left);
      if (!IsAxis(left)) continue;
      name = std::string(left);
      return unit.scale;
    }
  }
  return 1;
}

}  // namespace

bool IsAxis(absl::string_view name) {
  return name.size() == 1 && absl::StrContains("xyzXYZ", name[0]);
}

ColumnName UnderstandColumn(absl::string_view called) {
  called = absl::StripAsciiWhitespace(called);
  if (called.size() >= 2 && called.front() == '"' && called.back() == '"') {
    called = called.substr(1, called.size() - 2);
  }
  while (absl::ConsumePrefix(&called, "/") || absl::ConsumePrefix(&called, "#")) {
  }
  called = absl::StripAsciiWhitespace(called);
  ColumnName column{std::string(called)};
  std::string lower = absl::AsciiStrToLower(called);
  lower = std::string(absl::StripPrefix(lower, "scalar_"));
  if (const absl::string_view axis = AxisOfTuple(lower); !axis.empty()) lower = std::string(axis);
  column.scale = TakeUnit(lower);
  if (lower == "laser_id" || lower == "laserid" || lower == "channel") lower = "ring";
  if (lower == "i") lower = "intensity";
  if (IsAxis(lower) || lower == "intensity" || lower == "ring" ||
      absl::StartsWith(absl::AsciiStrToLower(called), "scalar_")) {
    column.name = lower;
  }
  return column;
}

}  // namespace isthmus::formats
