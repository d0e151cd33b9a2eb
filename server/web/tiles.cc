#include "server/web/tiles.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/strings/strip.h>

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/map/map_name.h"
#include "isthmus/v1/map_service.pb.h"
#include "server/web/answers.h"
#include "server/web/caller.h"
#include "server/web/limits.h"
#include "server/web/map_query.h"
#include "server/web/rpc_call.h"

namespace isthmus::web {
namespace {

// False where the path names none.
bool ReadTileId(absl::string_view path, v1::GetTileRequest* wanted) {
  if (!absl::ConsumePrefix(&path, "/tiles/") || !absl::ConsumeSuffix(&path, ".pts")) return false;
  const std::vector<absl::string_view> parts = absl::StrSplit(path, '/');
  uint32_t level = 0;
  int32_t x = 0, y = 0;
  if (parts.size() != 4 || parts[0].empty() || !absl::SimpleAtoi(parts[1], &level) ||
      !absl::SimpleAtoi(parts[2], &x) || !absl::SimpleAtoi(parts[3], &y)) {
    return false;
  }
  const auto map = MapName::FromText(parts[0]);
  wanted->set_map(map.session().value());
  wanted->mutable_id()->set_component(map.number());
  wanted->mutable_id()->set_level(level);
  wanted->mutable_id()->set_x(x);
  wanted->mutable_id()->set_y(y);
  return true;
}

std::string ETagOf(uint64_t version) {
  return absl::StrCat("\"", absl::Hex(version, absl::kZeroPad16), "\"");
}

// 0: none that could be one of ours.
uint64_t VersionOf(absl::string_view etag) {
  absl::ConsumePrefix(&etag, "W/");
  uint64_t version = 0;
  const bool is_ours = absl::ConsumePrefix(&etag, "\"") && absl::ConsumeSuffix(&etag, "\"") &&
                       absl::SimpleHexAtoi(etag, &version);
  return is_ours ? version : 0;
}

class PointsSource final : public http::Source {
 public:
  PointsSource(std::unique_ptr<RpcCall> call, std::string first)
      : call_(std::move(call)), first_(std::move(first)) {}

  Next Take(std::string* piece) override {
    if (is_first_) {
      is_first_ = false;
      *piece = std::move(first_);
      return Next::kPiece;
    }
    std::string message;
    if (call_->Take({}, &message) == RpcCall::Next::kEnd) {
      return call_->status().ok() ? Next::kEnd : Next::kBroken;
    }
    v1::GetTileResponse response;
    if (!response.ParseFromString(message)) return Next::kBroken;
    *piece = std::move(*response.mutable_points());
    return Next::kPiece;
  }

 private:
  const std::unique_ptr<RpcCall> call_;
  std::string first_;
  bool is_first_ = true;
};

}  // namespace

http::Response AnswerTile(const http::Request& request,
                          const std::shared_ptr<grpc::Channel>& channel) {
  if (request.method != "GET") return WrongMethod("GET");
  if (absl::Status known = CheckQuery(request, {}); !known.ok()) return ErrorAnswer(known);
  v1::GetTileRequest wanted;
  if (!ReadTileId(request.path, &wanted)) {
    return ErrorAnswer(absl::NotFoundError("tiles are at /tiles/MAP/LEVEL/X/Y.pts"));
  }
  wanted.set_have_version(VersionOf(request.Header("if-none-match").value_or("")));
  RpcCall::Request asked = RpcCall::For(request, "MapService/GetTile", wanted.SerializeAsString());
  asked.deadline = kCallTime;
  auto call = std::make_unique<RpcCall>(channel, std::move(asked));
  std::string message;
  if (call->Take({}, &message) != RpcCall::Next::kMessage) return ErrorAnswer(call->status());
  v1::GetTileResponse first;
  if (!first.ParseFromString(message)) return ErrorAnswer(absl::InternalError("no tile came"));
  nlohmann::json robots = nlohmann::json::array();
  for (const std::string& robot : first.robots()) robots.push_back(robot);
  http::Response response;
  response.Set("ETag", ETagOf(first.info().version()));
  response.Set("Isthmus-Revision", absl::StrCat(first.revision()));
  response.Set("Cache-Control", "private, no-cache");
  if (first.not_modified()) {
    response.code = 304;
    return response;
  }
  response.Set("Content-Type", "application/octet-stream");
  response.Set("Isthmus-Robots", robots.dump(-1, ' ', true));  // Headers are ASCII.
  response.source =
      std::make_unique<PointsSource>(std::move(call), std::move(*first.mutable_points()));
  return response;
}

}  // namespace isthmus::web
