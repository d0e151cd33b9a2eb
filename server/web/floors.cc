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
#include "core/floors/rooms.h"
#include "core/floors/rooms_file.h"
#include "server/web/answers.h"
#include "server/web/limits.h"
#include "server/web/map_query.h"
#include "server/web/map_read.h"

namespace isthmus::web {
namespace {

constexpr absl::string_view kYaml = ".yaml", kPgm = ".pgm", kRooms = ".rooms.json";

struct FloorAddress {
  MapName map;
  absl::string_view ending;  // The file's; empty: the list of floors.
  uint32_t floor = 0;
};

// False where the path names none.
bool ReadFloorAddress(absl::string_view path, FloorAddress* address) {
  if (!absl::ConsumePrefix(&path, "/floors/")) return false;
  const std::vector<absl::string_view> parts = absl::StrSplit(path, '/');
  if (parts[0].empty()) return false;
  address->map = MapName::FromText(parts[0]);
  if (parts.size() != 2) return parts.size() == 1;
  absl::string_view name = parts[1];
  for (const absl::string_view ending : {kYaml, kPgm, kRooms}) {
    if (absl::ConsumeSuffix(&name, ending)) address->ending = ending;
  }
  return !address->ending.empty() && absl::ConsumePrefix(&name, "floor_") &&
         absl::SimpleAtoi(name, &address->floor);
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
                    {"yaml", FloorName(i, kYaml)},
                    {"pgm", FloorName(i, kPgm)},
                    {"rooms", FloorName(i, kRooms)}});
  }
  return JsonAnswer(list.dump());
}

absl::Status TooLarge() {
  return absl::ResourceExhaustedError(
      "that much of the map at once is too large here: give a coarser ?resolution= or a ?box=");
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
  if (absl::IsResourceExhausted(space.status())) return TooLarge();
  if (!space.ok()) return space.status();
  return floors::GridOf(*std::move(space), floor, std::nullopt);
}

absl::StatusOr<http::Response> MakeFloor(const rpc::Call& call, const FloorAddress& address,
                                         const v1::ExportMapRequest& asked) {
  const server::MapReader& reader = call.pipeline().reader();
  const std::shared_ptr<const server::MapView> view = reader.View();
  const auto all = FindFloors(reader, *view, address.map);
  if (!all.ok()) return all.status();
  if (address.ending.empty()) return ListFloors(*all);
  if (address.floor >= all->size()) {
    return absl::NotFoundError(absl::StrCat("no floor ", address.floor, ": map ",
                                            address.map.ToText(), " has ", all->size()));
  }
  const auto map = DrawFloor(call, *view, (*all)[address.floor], asked);
  if (!map.ok()) return map.status();
  if (address.ending == kPgm) {
    return FreshAnswer("image/x-portable-graymap", floors::FormatPgm(*map));
  }
  if (address.ending == kYaml) {
    return TextAnswer(floors::FormatMapYaml(*map, FloorName(address.floor, kPgm)));
  }
  const auto rooms = floors::RoomsOf(*map);
  if (absl::IsResourceExhausted(rooms.status())) return TooLarge();
  if (!rooms.ok()) return rooms.status();
  return FreshAnswer("application/geo+json", floors::FormatRooms(*rooms));
}

}  // namespace

http::Response AnswerFloor(const http::Request& request, rpc::Gate& gate, StreamSlots* slots) {
  if (request.method != "GET") return WrongMethod("GET");
  FloorAddress address;
  if (!ReadFloorAddress(request.path, &address)) {
    return ErrorAnswer(absl::NotFoundError(
        "floors are listed at /floors/MAP, and drawn at /floors/MAP/floor_N.yaml and floor_N.pgm, "
        "with their rooms at floor_N.rooms.json"));
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
  return ReadMap(gate, request, address.ending.empty() ? "GetTrajectory" : "ExportMap", asked,
                 [&](const rpc::Call& call) { return MakeFloor(call, address, asked); });
}

}  // namespace isthmus::web
