#include "server/web/floors.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/strings/strip.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "api/convert/map.h"
#include "api/convert/map_name.h"
#include "core/floors/floors.h"
#include "core/floors/grid_map.h"
#include "core/floors/limits.h"
#include "server/web/answers.h"
#include "server/web/limits.h"
#include "server/web/map_query.h"
#include "server/web/map_read.h"

namespace isthmus::web {
namespace {

struct FloorAddress {
  MapName map;
  bool is_list = false, is_image = false;
  uint32_t floor = 0;
};

// False where the path names none.
bool ReadFloorAddress(absl::string_view path, FloorAddress* address) {
  if (!absl::ConsumePrefix(&path, "/floors/")) return false;
  const std::vector<absl::string_view> parts = absl::StrSplit(path, '/');
  if (parts[0].empty()) return false;
  address->map = MapName::FromText(parts[0]);
  address->is_list = parts.size() == 1;
  if (parts.size() != 2) return address->is_list;
  absl::string_view name = parts[1];
  address->is_image = absl::ConsumeSuffix(&name, ".pgm");
  return (address->is_image || absl::ConsumeSuffix(&name, ".yaml")) &&
         absl::ConsumePrefix(&name, "floor_") && absl::SimpleAtoi(name, &address->floor);
}

std::string FloorName(size_t floor, absl::string_view ending) {
  return absl::StrCat("floor_", floor, ending);
}

absl::StatusOr<std::vector<floors::Floor>> FindFloors(const server::MapReader& reader,
                                                      const server::MapView& view,
                                                      const MapName& map) {
  const auto tracks = reader.GetTracks(view, map);
  if (!tracks.ok()) return tracks.status();
  if (tracks->empty()) {
    return absl::NotFoundError(absl::StrCat("no robot is in map ", map.ToText(), " yet"));
  }
  std::vector<Eigen::Vector3d> stations;
  for (const Track& track : *tracks) floors::AddStations(track.poses, &stations);
  return floors::FloorsOf(stations);
}

http::Response ListFloors(const std::vector<floors::Floor>& all) {
  nlohmann::json list = nlohmann::json::array();
  for (size_t i = 0; i < all.size(); ++i) {
    list.push_back({{"floor", i},
                    {"lowest_m", all[i].lowest_m},
                    {"highest_m", all[i].highest_m},
                    {"yaml", FloorName(i, ".yaml")},
                    {"pgm", FloorName(i, ".pgm")}});
  }
  return JsonAnswer(list.dump());
}

// The free space of its heights alone.
absl::StatusOr<floors::GridMap> DrawFloor(const rpc::Call& call, const server::MapView& view,
                                          const floors::Floor& floor, v1::ExportMapRequest asked) {
  const floors::HeightBand heights = floors::HeightsAround(floor);
  if (!asked.has_box()) {
    for (v1::Vector3* corner :
         {asked.mutable_box()->mutable_min(), asked.mutable_box()->mutable_max()}) {
      const double far = corner == asked.mutable_box()->mutable_min() ? -kEndlessM : kEndlessM;
      corner->set_x(far);
      corner->set_y(far);
      corner->set_z(far);
    }
  }
  v1::Vector3* min = asked.mutable_box()->mutable_min();
  v1::Vector3* max = asked.mutable_box()->mutable_max();
  min->set_z(std::max(min->z(), heights.lowest_m));
  max->set_z(std::min(max->z(), heights.highest_m));
  if (min->z() > max->z()) return floors::NothingThere();
  const auto wanted = convert::FromMessage(asked);
  if (!wanted.ok()) return wanted.status();
  auto space = call.pipeline().reader().ReadFreeSpace(
      view, *wanted, kFloorBytes, [&call] { return !call.Gone() && call.Allowed().ok(); });
  if (absl::IsResourceExhausted(space.status())) {
    return absl::ResourceExhaustedError(
        "that much of the map at once is too large here: give a coarser ?resolution= or a ?box=");
  }
  if (!space.ok()) return space.status();
  return floors::GridOf(*std::move(space), floor, std::nullopt);
}

absl::StatusOr<http::Response> MakeFloor(const rpc::Call& call, const FloorAddress& address,
                                         const v1::ExportMapRequest& asked) {
  const server::MapReader& reader = call.pipeline().reader();
  const std::shared_ptr<const server::MapView> view = reader.View();
  const auto all = FindFloors(reader, *view, address.map);
  if (!all.ok()) return all.status();
  if (address.is_list) return ListFloors(*all);
  if (address.floor >= all->size()) {
    return absl::NotFoundError(absl::StrCat("no floor ", address.floor, ": map ",
                                            address.map.ToText(), " has ", all->size()));
  }
  const auto map = DrawFloor(call, *view, (*all)[address.floor], asked);
  if (!map.ok()) return map.status();
  if (!address.is_image) {
    return TextAnswer(floors::FormatMapYaml(*map, FloorName(address.floor, ".pgm")));
  }
  return FreshAnswer("image/x-portable-graymap", floors::FormatPgm(*map));
}

}  // namespace

http::Response AnswerFloor(const http::Request& request, rpc::Gate& gate, StreamSlots* slots) {
  if (request.method != "GET") return WrongMethod("GET");
  FloorAddress address;
  if (!ReadFloorAddress(request.path, &address)) {
    return ErrorAnswer(absl::NotFoundError(
        "floors are listed at /floors/MAP, and drawn at /floors/MAP/floor_N.yaml and floor_N.pgm"));
  }
  v1::ExportMapRequest asked;
  asked.set_format(v1::ExportMapRequest::OCTOMAP_BINARY);
  absl::Status status = CheckQuery(request, {"resolution", "box"});
  if (status.ok()) status = ReadMapQuery(request, &asked);
  if (!status.ok()) return ErrorAnswer(status);
  if (asked.resolution_m() == 0) asked.set_resolution_m(floors::kGridCellM);
  convert::PutMap(address.map, asked);
  const auto slot = slots->Take(request.peer);
  if (slot == nullptr) return NoSlotLeft();
  return ReadMap(gate, request, address.is_list ? "GetTrajectory" : "ExportMap", asked,
                 [&](const rpc::Call& call) { return MakeFloor(call, address, asked); });
}

}  // namespace isthmus::web
