#include "server/web/map_files.h"

#include <absl/status/statusor.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <absl/strings/strip.h>

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "isthmus/v1/map_service.pb.h"
#include "server/web/answers.h"
#include "server/web/caller.h"
#include "server/web/limits.h"
#include "server/web/rpc_call.h"

namespace isthmus::web {
namespace {

constexpr char kFolder[] = "/export/map.";

std::optional<v1::ExportMapRequest::Format> FormatOf(absl::string_view ending) {
  if (ending == "pcd") return v1::ExportMapRequest::PCD_BINARY;
  if (ending == "ply") return v1::ExportMapRequest::PLY;
  if (ending == "bt") return v1::ExportMapRequest::OCTOMAP_BINARY;
  if (ending == "ot") return v1::ExportMapRequest::OCTOMAP_FULL;
  return std::nullopt;
}

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

absl::StatusOr<v1::ExportMapRequest> ReadQuery(const http::Request& request) {
  v1::ExportMapRequest wanted;
  absl::string_view ending = request.path;
  const auto format = absl::ConsumePrefix(&ending, kFolder) ? FormatOf(ending) : std::nullopt;
  if (!format) {
    return absl::NotFoundError(
        "the map is at /export/map.pcd, map.ply, map.bt and map.ot; `isthmus export` has more");
  }
  wanted.set_format(*format);
  if (const auto text = request.Query("component")) {
    uint32_t component = 0;
    if (!absl::SimpleAtoi(*text, &component)) {
      return absl::InvalidArgumentError("component is a number from 0 on");
    }
    wanted.set_component(component);
  }
  if (const auto text = request.Query("resolution")) {
    double resolution = 0;
    if (!absl::SimpleAtod(*text, &resolution)) {
      return absl::InvalidArgumentError("resolution is a number of metres");
    }
    wanted.set_resolution_m(resolution);
  }
  if (const auto text = request.Query("box")) {
    if (absl::Status status = ReadBox(*text, wanted.mutable_box()); !status.ok()) return status;
  }
  return wanted;
}

class FileSource final : public http::Source {
 public:
  FileSource(std::unique_ptr<RpcCall> call, std::string first,
             std::unique_ptr<StreamSlots::Slot> slot)
      : slot_(std::move(slot)), call_(std::move(call)), message_(std::move(first)) {}

  Next Take(std::string* piece) override {
    if (!is_first_ && call_->Take({}, &message_) != RpcCall::Next::kMessage) {
      return call_->status().ok() && is_whole_ ? Next::kEnd : Next::kBroken;
    }
    is_first_ = false;
    v1::ExportMapResponse response;
    if (!response.ParseFromString(message_)) return Next::kBroken;
    is_whole_ = response.last();
    *piece = std::move(*response.mutable_data());
    return Next::kPiece;
  }

 private:
  const std::unique_ptr<StreamSlots::Slot> slot_;  // Given up when the call is over.
  const std::unique_ptr<RpcCall> call_;
  std::string message_;
  bool is_first_ = true, is_whole_ = false;
};

}  // namespace

http::Response AnswerMapFile(const http::Request& request,
                             const std::shared_ptr<grpc::Channel>& channel, StreamSlots* slots) {
  if (request.method != "GET") return WrongMethod("GET");
  const auto wanted = ReadQuery(request);
  if (!wanted.ok()) return ErrorAnswer(wanted.status());
  auto slot = slots->Take();
  if (slot == nullptr) return NoSlotLeft();
  RpcCall::Request asked;
  asked.method = "/isthmus.v1.MapService/ExportMap";
  asked.headers = CallHeaders(request);
  asked.message = wanted->SerializeAsString();
  asked.gone = request.gone;
  auto call = std::make_unique<RpcCall>(channel, std::move(asked));
  std::string first;
  if (call->Take({}, &first) != RpcCall::Next::kMessage) return ErrorAnswer(call->status());
  http::Response response;
  response.Set("Content-Type", "application/octet-stream");
  const std::string name = request.path.substr(request.path.rfind('/') + 1);
  response.Set("Content-Disposition", absl::StrCat("attachment; filename=\"", name, "\""));
  response.Set("Cache-Control", "no-store");
  response.source =
      std::make_unique<FileSource>(std::move(call), std::move(first), std::move(slot));
  return response;
}

}  // namespace isthmus::web
