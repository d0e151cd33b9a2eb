#include "client/library/client.h"

#include <utility>

#include "client/library/convert.h"
#include "client/library/link.h"
#include "client/library/stream/memory_stream.h"
#include "client/library/stream/spooled_stream.h"

namespace isthmus::client {

using Stubs = Client::Link::Stubs;

Client::Client(std::shared_ptr<Link> link) : link_(std::move(link)) {}
Client::~Client() = default;

const std::string& Client::address() const { return link_->options().address; }

absl::StatusOr<std::unique_ptr<Client>> Client::Connect(const ClientOptions& options) {
  auto link = std::make_shared<Link>(options);
  if (!options.require_server) return std::unique_ptr<Client>(new Client(std::move(link)));
  if (absl::Status status = link->Probe(); !status.ok()) return status;
  return std::unique_ptr<Client>(new Client(std::move(link)));
}

absl::StatusOr<Session> Client::CreateSession(const std::string& robot, const std::string& sensor,
                                              const Pose& T_base_sensor,
                                              const std::string& odometry) {
  v1::CreateSessionRequest request = ToProto(SessionWish{robot, sensor, T_base_sensor, odometry});
  request.set_request_id(NewRequestId());
  v1::Session session;
  const absl::Status status =
      link_->Call(link_->options().call_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.sessions->CreateSession(&context, request, &session);
      });
  if (!status.ok()) return status;
  return FromProto(session);
}

namespace {

absl::StatusOr<v1::Session> AskFor(const SessionId& id, Client::Link& link) {
  v1::GetSessionRequest request;
  request.set_session(id.value());
  v1::Session session;
  const absl::Status status =
      link.Call(link.options().call_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.sessions->GetSession(&context, request, &session);
      });
  if (!status.ok()) return status;
  return session;
}

}  // namespace

absl::StatusOr<Session> Client::GetSession(const SessionId& id) {
  const absl::StatusOr<v1::Session> session = AskFor(id, *link_);
  if (!session.ok()) return session.status();
  return FromProto(*session);
}

absl::StatusOr<std::vector<Session>> Client::ListSessions() {
  v1::ListSessionsResponse response;
  const absl::Status status =
      link_->Call(link_->options().call_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.sessions->ListSessions(&context, v1::ListSessionsRequest(), &response);
      });
  if (!status.ok()) return status;
  std::vector<Session> sessions;
  for (const v1::Session& session : response.sessions()) sessions.push_back(FromProto(session));
  return sessions;
}

absl::StatusOr<Session> Client::FinishSession(const SessionId& id) {
  return FinishAt(*link_, id, 0);
}

absl::Status Client::DeleteSession(const SessionId& id) {
  v1::DeleteSessionRequest request;
  request.set_session(id.value());
  // Not repeated: after a lost answer the second attempt would say that there is no such session.
  return link_->CallOnce(link_->options().call_timeout_s,
                         [&](Stubs& stubs, grpc::ClientContext& context) {
                           v1::DeleteSessionResponse response;
                           return stubs.sessions->DeleteSession(&context, request, &response);
                         });
}

absl::StatusOr<std::unique_ptr<ScanStream>> Client::OpenScanStream(
    const SessionId& id, const ScanStreamOptions& options) {
  const absl::StatusOr<v1::Session> session = AskFor(id, *link_);
  if (!session.ok()) return session.status();
  if (!options.spool_dir.empty()) return SpooledStream::Open(link_, options, {.session = *session});
  return std::make_unique<ScanStream>(
      std::make_unique<MemoryStream>(link_, id, session->last_sequence(), options));
}

absl::StatusOr<std::unique_ptr<ScanStream>> Client::ResumeScanStream(
    const ScanStreamOptions& options) {
  return SpooledStream::Open(link_, options, {});
}

absl::StatusOr<std::unique_ptr<ScanStream>> Client::OpenSpool(const SessionWish& wish,
                                                              const ScanStreamOptions& options) {
  return SpooledStream::Open(link_, options, {.request = ToProto(wish)});
}

}  // namespace isthmus::client
