#include "core/formats/las_units.h"

#include <absl/strings/ascii.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/codec/column.h"

namespace isthmus::formats {
namespace {

constexpr double kFootM = 0.3048, kUsFootM = 1200.0 / 3937;

absl::Status Degrees(absl::string_view system) {
  return absl::InvalidArgumentError(absl::StrCat(
      "LAS: coordinates are degrees", system.empty() ? "" : " of ", system.substr(0, 60),
      ", not metres: project the file first, to UTM for one, e.g. with QGIS, PDAL or las2las"));
}

// "KEYWORD[words and nodes]": its words, which may be quoted, are nodes without children.
struct WktNode {
  std::string word;  // A keyword's is in capitals.
  std::vector<WktNode> children;

  const WktNode* Child(std::initializer_list<absl::string_view> words) const {
    for (const WktNode& child : children) {
      for (const absl::string_view wanted : words) {
        if (!child.children.empty() && child.word == wanted) return &child;
      }
    }
    return nullptr;
  }
  absl::string_view name() const {
    return children.empty() ? absl::string_view() : absl::string_view(children[0].word);
  }
};

// Damaged text gives what is before the damage.
class WktParser {
 public:
  explicit WktParser(absl::string_view text) : left_(text) {}

  WktNode Node(int depth = 0) {
    constexpr int kDeepest = 32;  // WKT 2 has a dozen; bounds the stack.
    SkipBlanks();
    WktNode node;
    if (left_.substr(0, 1) == "\"") {
      node.word = Quoted();
      return node;
    }
    const size_t end = std::min(left_.find_first_of("[](),\""), left_.size());
    node.word = absl::AsciiStrToUpper(absl::StripAsciiWhitespace(left_.substr(0, end)));
    left_.remove_prefix(end);
    if (left_.empty() || (left_[0] != '[' && left_[0] != '(') || depth == kDeepest) return node;
    do {
      left_.remove_prefix(1);
      node.children.push_back(Node(depth + 1));
      SkipBlanks();
    } while (left_.substr(0, 1) == ",");
    if (!left_.empty()) left_.remove_prefix(1);
    return node;
  }

 private:
  void SkipBlanks() { left_ = absl::StripLeadingAsciiWhitespace(left_); }
  std::string Quoted() {
    left_.remove_prefix(1);
    const size_t end = std::min(left_.find('"'), left_.size());
    std::string text(left_.substr(0, end));
    left_.remove_prefix(std::min(end + 1, left_.size()));
    return text;
  }

  absl::string_view left_;
};

// The unit that is the node's own, or that of its first axis.
std::optional<double> UnitOf(const WktNode& system) {
  const WktNode* unit = system.Child({"UNIT", "LENGTHUNIT"});
  const WktNode* axis = system.Child({"AXIS"});
  if (unit == nullptr && axis != nullptr) unit = axis->Child({"UNIT", "LENGTHUNIT"});
  double metres = 0;
  // Surveys are in lengths of daily use.
  if (unit == nullptr || unit->children.size() < 2 ||
      !absl::SimpleAtod(unit->children[1].word, &metres) || !(metres >= 1e-4 && metres <= 1e4)) {
    return std::nullopt;
  }
  return metres;
}

bool IsGeographic(const WktNode& system) {
  if (system.word == "GEOGCS" || system.word == "GEOGCRS" || system.word == "GEOGRAPHICCRS") {
    return true;
  }
  const WktNode* axes = system.Child({"CS"});  // A GEODCRS has either kind.
  return axes != nullptr && absl::AsciiStrToUpper(axes->name()) == "ELLIPSOIDAL";
}

// A number of Geo keys' table of units (EPSG).
std::optional<double> UnitOfCode(int code) {
  if (code == 9001) return 1;
  if (code == 9002) return kFootM;
  if (code == 9003) return kUsFootM;
  return std::nullopt;
}

struct GeoKeys {
  absl::string_view directory, doubles;

  // The value of a key that stands in the directory itself.
  std::optional<int> Value(uint16_t key) const { return Find(key, 0); }
  // The first of a key's doubles.
  std::optional<double> Double(uint16_t key) const {
    constexpr uint16_t kDoubles = 34736;
    const std::optional<int> index = Find(key, kDoubles);
    if (!index || (static_cast<size_t>(*index) + 1) * 8 > doubles.size()) return std::nullopt;
    return codec::LoadAs<double>(doubles.data() + 8 * *index);
  }

 private:
  std::optional<int> Find(uint16_t key, uint16_t place) const {
    // After a head of four numbers, four for each key: it, where its value stands, count, value.
    for (size_t at = 8; at + 8 <= directory.size(); at += 8) {
      if (codec::LoadAs<uint16_t>(directory.data() + at) != key) continue;
      if (codec::LoadAs<uint16_t>(directory.data() + at + 2) != place) continue;
      return codec::LoadAs<uint16_t>(directory.data() + at + 6);
    }
    return std::nullopt;
  }
};

}  // namespace

absl::StatusOr<LasUnits> UnitsOfWkt(absl::string_view wkt) {
  const WktNode root = WktParser(wkt.substr(0, wkt.find('\0'))).Node();
  const WktNode* system = &root;
  const WktNode* vertical = nullptr;
  // Compounds and bounds hold the systems that are meant, first the horizontal one.
  for (;;) {
    const WktNode* inner = system->Child({"SOURCECRS"});
    if (system->word == "COMPD_CS" || system->word == "COMPOUNDCRS") {
      vertical = system->Child({"VERT_CS", "VERTCS", "VERTCRS", "VERTICALCRS"});
      inner =
          system->Child({"PROJCS", "PROJCRS", "PROJECTEDCRS", "GEOGCS", "GEOGCRS", "GEOGRAPHICCRS",
                         "GEODCRS", "GEODETICCRS", "GEOCCS", "LOCAL_CS", "ENGCRS", "BOUNDCRS"});
    } else if (system->word == "SOURCECRS") {
      inner = &system->children[0];
    }
    if (inner == nullptr) break;
    system = inner;
  }
  if (IsGeographic(*system)) return Degrees(system->name());
  LasUnits units;
  units.horizontal_m = UnitOf(*system).value_or(1);
  units.vertical_m = units.horizontal_m;
  if (vertical != nullptr) units.vertical_m = UnitOf(*vertical).value_or(units.vertical_m);
  return units;
}

absl::StatusOr<LasUnits> UnitsOfGeoKeys(absl::string_view directory, absl::string_view doubles) {
  // Section 7.1.2 and 7.4: the numbers of the keys.
  constexpr uint16_t kModelType = 1024, kProjectedUnits = 3076, kProjectedUnitSize = 3077,
                     kVerticalUnits = 4099;
  constexpr int kGeographic = 2;
  const GeoKeys keys{directory, doubles};
  if (keys.Value(kModelType) == kGeographic) return Degrees("");
  LasUnits units;
  if (const std::optional<int> code = keys.Value(kProjectedUnits)) {
    const double own = keys.Double(kProjectedUnitSize).value_or(1);
    units.horizontal_m = UnitOfCode(*code).value_or(own >= 1e-4 && own <= 1e4 ? own : 1);
  }
  units.vertical_m = units.horizontal_m;
  if (const std::optional<int> code = keys.Value(kVerticalUnits)) {
    units.vertical_m = UnitOfCode(*code).value_or(units.vertical_m);
  }
  return units;
}

}  // namespace isthmus::formats
