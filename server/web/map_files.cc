#include "server/web/map_files.h"

#include <absl/status/statusor.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/strip.h>

#include <optional>
#include <string>
#include <utility>

#include "isthmus/v1/map_service.pb.h"
#include "server/web/answers.h"
#include "server/web/limits.h"
#include "server/web/map_query.h"
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

absl::StatusOr<v1::ExportMapRequest> ReadQuery(const http::Request& request) {
  v1::ExportMapRequest wanted;
  absl::string_view ending = request.path;
  const auto format = absl::ConsumePrefix(&ending, kFolder) ? FormatOf(ending) : std::nullopt;
  if (!format) {
    return absl::NotFoundError(
        "the map is at /export/map.pcd, map.ply, map.bt and map.ot; `isthmus export` has more");
  }
  wanted.set_format(*format);
  if (absl::Status status = ReadMapQuery(request, &wanted); !status.ok()) return status;
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

http::Response SendMapFile(const http::Request& request,
                           const std::shared_ptr<grpc::Channel>& channel,
                           const v1::ExportMapRequest& wanted, const std::string& name,
                           StreamSlots* slots) {
  auto slot = slots->Take();
  if (slot == nullptr) return NoSlotLeft();
  auto call = std::make_unique<RpcCall>(
      channel, RpcCall::For(request, "MapService/ExportMap", wanted.SerializeAsString()));
  std::string first;
  if (call->Take({}, &first) != RpcCall::Next::kMessage) return ErrorAnswer(call->status());
  http::Response response;
  response.Set("Content-Type", "application/octet-stream");
  response.Set("Content-Disposition", absl::StrCat("attachment; filename=\"", name, "\""));
  response.Set("Cache-Control", "no-store");
  response.source =
      std::make_unique<FileSource>(std::move(call), std::move(first), std::move(slot));
  return response;
}

http::Response AnswerMapFile(const http::Request& request,
                             const std::shared_ptr<grpc::Channel>& channel, StreamSlots* slots) {
  if (request.method != "GET") return WrongMethod("GET");
  const auto wanted = ReadQuery(request);
  if (!wanted.ok()) return ErrorAnswer(wanted.status());
  return SendMapFile(request, channel, *wanted, request.path.substr(request.path.rfind('/') + 1),
                     slots);
}

}  // namespace isthmus::web
