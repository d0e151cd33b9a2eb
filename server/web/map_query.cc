#include "server/web/map_query.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/strings/str_split.h>

#include <array>
#include <set>
#include <string>
#include <vector>

#include "api/convert/map.h"
#include "api/convert/map_name.h"

namespace isthmus::web {
namespace {

absl::Status ReadBox(const std::string& text, v1::Box* box) {
  const std::vector<absl::string_view> parts = absl::StrSplit(text, ',');
  std::array<double, 6> numbers = {};
  bool is_good = parts.size() == numbers.size();
  for (size_t i = 0; is_good && i < numbers.size(); ++i) {
    is_good = absl::SimpleAtod(parts[i], &numbers[i]);
  }
  if (!is_good) {
    return absl::InvalidArgumentError(
        "give a box as six numbers in metres: ?box=minx,miny,minz,maxx,maxy,maxz");
  }
  const auto set = [&numbers](size_t from, v1::Vector3* corner) {
    corner->set_x(numbers[from]);
    corner->set_y(numbers[from + 1]);
    corner->set_z(numbers[from + 2]);
  };
  set(0, box->mutable_min());
  set(3, box->mutable_max());
  return absl::OkStatus();
}

}  // namespace

MapName ReadMapName(const http::Request& request) {
  for (const char* name : {"map", "component"}) {
    if (const auto text = request.Query(name)) return MapName::FromText(*text);
  }
  return {};
}

absl::Status CheckQuery(const http::Request& request, std::set<absl::string_view> known) {
  known.insert("site");
  std::set<absl::string_view> given;
  for (const auto& [name, value] : request.query) {
    if (!known.contains(name)) {
      return absl::InvalidArgumentError(
          absl::StrCat("?", name, "= means nothing; known here: ", absl::StrJoin(known, ", ")));
    }
    if (!given.insert(name).second) {
      return absl::InvalidArgumentError(absl::StrCat("?", name, "= is there twice"));
    }
  }
  return absl::OkStatus();
}

absl::Status ReadMapQuery(const http::Request& request, v1::ExportMapRequest* wanted) {
  convert::PutMap(ReadMapName(request), *wanted);
  if (const auto text = request.Query("resolution")) {
    double resolution = 0;
    if (!absl::SimpleAtod(*text, &resolution)) {
      return absl::InvalidArgumentError("resolution is a number of metres");
    }
    wanted->set_resolution_m(resolution);
  }
  if (const auto text = request.Query("box")) {
    if (absl::Status status = ReadBox(*text, wanted->mutable_box()); !status.ok()) return status;
  }
  return convert::FromMessage(*wanted).status();
}

}  // namespace isthmus::web
