#include "server/rpc/localise_stream.h"

#include <absl/strings/str_cat.h>

#include <string>
#include <utility>

#include "api/convert/cloud.h"
#include "api/convert/localisation.h"
#include "isthmus/v1/localisation_service.grpc.pb.h"
#include "server/rpc/reply.h"
#include "server/rpc/services.h"
#include "server/rpc/streams/messages.h"

namespace isthmus::rpc {

absl::Status LocaliseReactor::Open(const v1::LocaliseRequest& request) {
  if (request.has_begin() == (localiser_ != nullptr)) {
    return absl::InvalidArgumentError(
        localiser_ == nullptr ? "the first message must have begin: what the robot carries"
                              : "only the first message may have begin: open another stream");
  }
  if (!request.has_begin()) return absl::OkStatus();
  auto wanted = convert::FromMessage(request.begin());
  if (!wanted.ok()) return wanted.status();
  if (wanted->robot.empty()) wanted->robot = call().caller.OnlyRobot();
  if (!wanted->robot.empty()) {
    if (absl::Status own = call().CheckRobot(wanted->robot); !own.ok()) return own;
  }
  // Another robot must not find out whether there is a robot of that name.
  if (!wanted->in_map_of.empty()) {
    if (absl::Status own = call().CheckRobot(wanted->in_map_of); !own.ok()) return own;
  }
  auto opened = call().pipeline().OpenLocaliser(*wanted);
  if (!opened.ok()) return opened.status();
  localiser_ = *std::move(opened);
  robot_ = wanted->robot;
  NoteEvent(EventKind::kLocalisingBegun,
            absl::StrCat("is localised in ",
                         wanted->in_map_of.empty()
                             ? "the largest map"
                             : absl::StrCat("the map of ", wanted->in_map_of.value())));
  return absl::OkStatus();
}

void LocaliseReactor::NoteEvent(EventKind kind, const std::string& what) const {
  Event event;
  event.kind = kind;
  event.actor = call().actor();
  event.robot = robot_;
  event.text = absl::StrCat(robot_.empty() ? "a robot without a name" : robot_.value(), " ", what);
  call().pipeline().events().Note(std::move(event));
}

absl::StatusOr<LocalisedScan> LocaliseReactor::Locate(v1::LocaliseRequest* request) {
  ScanUpload scan{request->scan().sequence(), request->scan().end_stamp_ns(), {}};
  auto payload = convert::FromMessage(std::move(*request->mutable_scan()->mutable_cloud()));
  const absl::Status usable = payload.status();
  if (usable.ok()) scan.payload = *std::move(payload);
  auto located = localiser_->Locate(scan);  // One without a payload is rejected, and counted, too.
  if (!located.ok()) return located;
  if (!usable.ok()) located->rejected = std::string(usable.message());
  ++scans_;
  if (located->T_map_sensor) ++found_;
  return located;
}

void LocaliseReactor::OnMessage(grpc::ByteBuffer message) {
  v1::LocaliseRequest request;
  absl::Status status = ReadMessage(&message, &request);
  if (status.ok()) status = Open(request);
  if (!status.ok()) return End(status);
  if (!request.has_scan()) return ReadNext();
  absl::StatusOr<LocalisedScan> located = Locate(&request);
  if (!located.ok()) return End(located.status());
  located->rejected = CutText(located->rejected, kMaxReason);
  place_ = ToBytes(convert::ToMessage(*located));
  StartWrite(&place_);
}

void LocaliseReactor::OnEnd() {
  if (localiser_ == nullptr) return;
  localiser_.reset();
  NoteEvent(EventKind::kLocalisingEnded,
            absl::StrCat("is not localised any more: its place was known at ", found_, " of ",
                         scans_, " scans"));
}

void LocaliseReactor::OnWriteDone(bool ok) {
  Post([this, ok] {
    if (!ok) return End(absl::CancelledError("the client went away"));
    ReadNext();
  });
}

namespace {

class LocalisationService final : public v1::LocalisationService::WithRawCallbackMethod_Localise<
                                      v1::LocalisationService::Service> {
 public:
  explicit LocalisationService(const ServiceParts& parts) : host_(parts.host) {}

  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* Localise(
      grpc::CallbackServerContext* context) override {
    return LocaliseReactorBase::Begin<LocaliseReactor>(&host_, context);
  }

 private:
  StreamHost& host_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeLocalisationService(const ServiceParts& parts) {
  return std::make_unique<LocalisationService>(parts);
}

}  // namespace isthmus::rpc
