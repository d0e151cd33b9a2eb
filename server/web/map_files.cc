#include "server/web/map_files.h"

#include <absl/status/statusor.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/strip.h>

#include <optional>
#include <string>
#include <utility>

#include "isthmus/v1/map_service.pb.h"
#include "server/map/map_view.h"
#include "server/web/answers.h"
#include "server/web/map_query.h"
#include "server/web/map_read.h"
#include "server/web/rpc_call.h"

namespace isthmus::web {
namespace {

constexpr char kFolder[] = "/export/";

absl::StatusOr<v1::ExportMapRequest> ReadQuery(const http::Request& request) {
  v1::ExportMapRequest wanted;
  const auto format = MapFileFormat(absl::StripPrefix(request.path, kFolder));
  if (!format) {
    return absl::NotFoundError(
        "the map is at /export/map.pcd, map.ply, map.bt and map.ot; `isthmus export` has more");
  }
  wanted.set_format(*format);
  absl::Status status = CheckQuery(request, {"map", "component", "resolution", "box", "revision"});
  if (status.ok()) status = ReadMapQuery(request, &wanted);
  if (!status.ok()) return status;
  return wanted;
}

absl::StatusOr<std::optional<int64_t>> ReadRevision(const http::Request& request) {
  const auto text = request.Query("revision");
  if (!text) return std::nullopt;
  int64_t revision = 0;
  if (absl::SimpleAtoi(*text, &revision)) return revision;
  return absl::InvalidArgumentError("revision is the number of one of the map's");
}

absl::Status AnotherRevision(int64_t has, int64_t wanted) {
  return absl::AbortedError(absl::StrCat("the map has revision ", has, ", not ", wanted));
}

// OK where the map of that revision is composed whole. Maps without the submaps whose turn is later
// have the same revision, and are not that file.
absl::Status CheckWhole(const server::MapView& view, int64_t revision) {
  const int64_t has = view.revision->revision;
  if (!view.IsComposed()) {
    return absl::UnavailableError(
        absl::StrCat("submaps of revision ", has, " wait to be composed: ask again"));
  }
  return has == revision ? absl::OkStatus() : AnotherRevision(has, revision);
}

class FileSource final : public http::Source {
 public:
  // `first`: the answer that has come already.
  FileSource(std::unique_ptr<RpcCall> call, v1::ExportMapResponse first,
             std::unique_ptr<StreamSlots::Slot> slot)
      : slot_(std::move(slot)), call_(std::move(call)), response_(std::move(first)) {}

  Next Take(std::string* piece) override {
    if (!std::exchange(is_first_, false)) {
      std::string message;
      if (call_->Take({}, &message) != RpcCall::Next::kMessage) {
        return call_->status().ok() && response_.last() ? Next::kEnd : Next::kBroken;
      }
      if (!response_.ParseFromString(message)) return Next::kBroken;
    }
    *piece = std::move(*response_.mutable_data());
    return Next::kPiece;
  }

 private:
  const std::unique_ptr<StreamSlots::Slot> slot_;  // Given up when the call is over.
  const std::unique_ptr<RpcCall> call_;
  v1::ExportMapResponse response_;  // The latest.
  bool is_first_ = true;
};

}  // namespace

std::optional<v1::ExportMapRequest::Format> MapFileFormat(absl::string_view name) {
  if (name == "map.pcd") return v1::ExportMapRequest::PCD_BINARY;
  if (name == "map.ply") return v1::ExportMapRequest::PLY;
  if (name == "map.bt") return v1::ExportMapRequest::OCTOMAP_BINARY;
  if (name == "map.ot") return v1::ExportMapRequest::OCTOMAP_FULL;
  return std::nullopt;
}

http::Response FileAnswer(const std::string& name, int64_t revision) {
  http::Response response;
  response.Set("Isthmus-Revision", absl::StrCat(revision));
  response.Set("Content-Type", "application/octet-stream");
  response.Set("Content-Disposition", absl::StrCat("attachment; filename=\"", name, "\""));
  response.Set("Cache-Control", "no-store");
  return response;
}

http::Response AnswerMapFile(const http::Request& request, rpc::Gate& gate,
                             const std::shared_ptr<grpc::Channel>& channel, StreamSlots* slots) {
  if (request.method != "GET") return WrongMethod("GET");
  const auto wanted = ReadQuery(request);
  if (!wanted.ok()) return ErrorAnswer(wanted.status());
  const auto revision = ReadRevision(request);
  if (!revision.ok()) return ErrorAnswer(revision.status());
  const bool is_composed = wanted->format() == v1::ExportMapRequest::PCD_BINARY ||
                           wanted->format() == v1::ExportMapRequest::PLY;
  if (revision->has_value() && is_composed) {
    const absl::Status whole =
        PassGate(gate, request, "GetStatus", v1::GetMapInfoRequest(), [&](const rpc::Call& call) {
          return CheckWhole(*call.pipeline().reader().View(), **revision);
        });
    if (!whole.ok()) return ErrorAnswer(whole);
  }
  auto slot = slots->Take(request.peer);
  if (slot == nullptr) return NoSlotLeft();
  auto call = std::make_unique<RpcCall>(
      channel, RpcCall::For(request, "MapService/ExportMap", wanted->SerializeAsString()));
  std::string first;
  if (call->Take({}, &first) != RpcCall::Next::kMessage) return ErrorAnswer(call->status());
  v1::ExportMapResponse begin;
  if (!begin.ParseFromString(first)) return ErrorAnswer(absl::InternalError("no such answer"));
  if (*revision && **revision != begin.revision()) {
    return ErrorAnswer(AnotherRevision(begin.revision(), **revision));
  }
  http::Response response =
      FileAnswer(request.path.substr(request.path.rfind('/') + 1), begin.revision());
  response.source =
      std::make_unique<FileSource>(std::move(call), std::move(begin), std::move(slot));
  return response;
}

}  // namespace isthmus::web
