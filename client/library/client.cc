#include "client/library/client.h"

#include <absl/strings/ascii.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "api/convert/session.h"
#include "client/library/link.h"
#include "client/library/list_stream.h"
#include "client/library/stream/scan_stream_impl.h"
#include "client/library/tls_files.h"
#include "core/address.h"
#include "core/site_name.h"

namespace isthmus::client {

using Stubs = Client::Link::Stubs;

Client::Client(std::shared_ptr<Link> link) : link_(std::move(link)) {}
Client::~Client() = default;

const std::string& Client::address() const { return link_->options().address; }

namespace {

// Without the space around it, such as the end of the line that it was read from. gRPC ends the
// process where a header holds anything but ASCII that prints.
absl::Status TrimToken(std::string* token) {
  absl::StripAsciiWhitespace(token);
  const bool is_good = std::all_of(token->begin(), token->end(), [](char c) {
    return absl::ascii_isprint(static_cast<unsigned char>(c));
  });
  if (is_good) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "the token has a character that is not allowed: a line break, or not ASCII");
}

}  // namespace

absl::StatusOr<std::unique_ptr<Client>> Client::Connect(ClientOptions options) {
  absl::Status status = CheckAddresses(options.address);
  if (status.ok()) status = TrimToken(&options.token);
  if (status.ok() && !options.site.empty()) status = CheckSiteName(options.site);
  if (status.ok()) status = CheckTlsFiles(options.tls);
  if (!status.ok()) return status;
  auto link = std::make_shared<Link>(options);
  if (!options.require_server) return std::unique_ptr<Client>(new Client(std::move(link)));
  if (status = link->Probe(); !status.ok()) return status;
  return std::unique_ptr<Client>(new Client(std::move(link)));
}

absl::StatusOr<SessionStatus> Client::CreateSession(const std::string& robot,
                                                    const std::string& sensor,
                                                    const Pose& T_base_sensor,
                                                    std::optional<OdometryMode> odometry) {
  return CreateSession(SessionRequest{RobotId(robot), sensor, odometry, T_base_sensor});
}

absl::StatusOr<SessionStatus> Client::CreateSession(SessionRequest asked) {
  if (asked.request_id.empty()) asked.request_id = NewRequestId();
  const v1::CreateSessionRequest request = convert::ToMessage(asked);
  v1::Session session;
  const absl::Status status =
      link_->Call(link_->options().call_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.sessions->CreateSession(&context, request, &session);
      });
  if (!status.ok()) return status;
  return convert::FromMessage(session);
}

namespace {

absl::StatusOr<v1::Session> AskFor(const SessionId& id, Client::Link& link) {
  v1::GetSessionRequest request;
  request.set_session(id.value());
  v1::Session session;
  absl::Status status =
      link.Call(link.options().call_timeout_s, [&](Stubs& stubs, grpc::ClientContext& context) {
        return stubs.sessions->GetSession(&context, request, &session);
      });
  if (status.ok()) status = CheckSession(session);
  if (!status.ok()) return status;
  return session;
}

void AddSessions(const v1::ListSessionsResponse& part, std::vector<SessionStatus>& sessions) {
  for (const v1::Session& session : part.sessions()) {
    sessions.push_back(convert::FromMessage(session));
  }
}

}  // namespace

absl::StatusOr<SessionStatus> Client::GetSession(const SessionId& id) {
  const absl::StatusOr<v1::Session> session = AskFor(id, *link_);
  if (!session.ok()) return session.status();
  return convert::FromMessage(*session);
}

absl::StatusOr<SessionStatus> Client::GetSessionOnce(const SessionId& id, double timeout_s) {
  v1::GetSessionRequest request;
  request.set_session(id.value());
  v1::Session session;
  absl::Status status = link_->NewCall(timeout_s)->GetSession(request, &session);
  if (status.ok()) status = CheckSession(session);
  if (!status.ok()) return status;
  return convert::FromMessage(session);
}

absl::StatusOr<std::vector<SessionStatus>> Client::ListSessions() {
  const auto open = [](Stubs& stubs, grpc::ClientContext& context) {
    return stubs.sessions->ListSessions(&context, v1::ListSessionsRequest());
  };
  return ReadList(*link_, open, AddSessions);
}

absl::StatusOr<SessionStatus> Client::FinishSession(const SessionId& id) {
  v1::FinishSessionRequest request;
  request.set_session(id.value());
  v1::Session finished;
  const absl::Status status = link_->Repeat(false, [&] {
    return link_->NewCall(link_->options().transfer_timeout_s)->FinishSession(request, &finished);
  });
  if (!status.ok()) return status;
  return convert::FromMessage(finished);
}

absl::StatusOr<std::unique_ptr<ScanStream>> Client::OpenScanStream(
    const SessionId& id, const ScanStreamOptions& options) {
  const absl::StatusOr<v1::Session> session = AskFor(id, *link_);
  if (!session.ok()) return session.status();
  return ScanStream::Impl::Open(link_, options, {.session = *session});
}

absl::StatusOr<std::unique_ptr<ScanStream>> Client::ResumeScanStream(
    const ScanStreamOptions& options) {
  return ScanStream::Impl::Open(link_, options, {});
}

absl::StatusOr<std::unique_ptr<ScanStream>> Client::OpenSpool(const SessionRequest& request,
                                                              const ScanStreamOptions& options) {
  return ScanStream::Impl::Open(link_, options, {.request = convert::ToMessage(request)});
}

}  // namespace isthmus::client
