#include "server/http/microhttpd_request.h"

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <arpa/inet.h>
#include <gnutls/gnutls.h>
#include <gnutls/x509.h>
#include <netinet/in.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "core/caught.h"

namespace isthmus::http {
namespace {

MHD_Result AddField(void* fields, MHD_ValueKind, const char* key, const char* value) {
  try {
    static_cast<Fields*>(fields)->emplace_back(key, value == nullptr ? "" : value);
  } catch (...) {
    return MHD_NO;
  }
  return MHD_YES;
}

Fields FieldsOf(MHD_Connection* connection, MHD_ValueKind kind) {
  Fields fields;
  MHD_get_connection_values(connection, kind, AddField, &fields);
  return fields;
}

std::string PeerOf(MHD_Connection* connection) {
  const auto* const info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
  if (info == nullptr || info->client_addr == nullptr) return "unknown";
  char text[INET6_ADDRSTRLEN] = "";
  if (info->client_addr->sa_family == AF_INET) {
    const auto& address = *reinterpret_cast<const sockaddr_in*>(info->client_addr);
    inet_ntop(AF_INET, &address.sin_addr, text, sizeof(text));
    return absl::StrCat("ipv4:", text, ":", ntohs(address.sin_port));
  }
  const auto& address = *reinterpret_cast<const sockaddr_in6*>(info->client_addr);
  inet_ntop(AF_INET6, &address.sin6_addr, text, sizeof(text));
  const std::string mapped = "::ffff:";  // One of IPv4 at a socket of both.
  if (std::string(text).starts_with(mapped) && std::strchr(text, '.') != nullptr) {
    return absl::StrCat("ipv4:", text + mapped.size(), ":", ntohs(address.sin6_port));
  }
  return absl::StrCat("ipv6:[", text, "]:", ntohs(address.sin6_port));
}

gnutls_session_t SessionOf(MHD_Connection* connection) {
  const auto* const info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_GNUTLS_SESSION);
  return info == nullptr ? nullptr : static_cast<gnutls_session_t>(info->tls_session);
}

}  // namespace

MicrohttpdRequest::MicrohttpdRequest(MHD_Connection* connection, Connection* watched,
                                     const char* path, const char* method)
    : connection_(connection), watched_(watched) {
  request_.method = method;
  request_.path = path;
  request_.headers = FieldsOf(connection, MHD_HEADER_KIND);
  request_.query = FieldsOf(connection, MHD_GET_ARGUMENT_KIND);
  request_.peer = PeerOf(connection);
  request_.is_tls = SessionOf(connection) != nullptr;
  request_.gone = [watched] { return watched->IsGone(); };
}

MHD_Result MicrohttpdRequest::Begin(const ListenerOptions& options) noexcept {
  wants_certificate_ = !options.tls.client_ca.empty();
  try {
    uint64_t size = 0;
    const std::optional<std::string> length = request_.Header("content-length");
    if (!length || (absl::SimpleAtoi(*length, &size) && size <= options.max_body)) return MHD_YES;
    return Send(Text(MHD_HTTP_CONTENT_TOO_LARGE,
                     absl::StrCat("a request has ", options.max_body, " bytes at most\n")));
  } catch (...) {
    return MHD_NO;
  }
}

MHD_Result MicrohttpdRequest::Take(const char* data, size_t size,
                                   const ListenerOptions& options) noexcept {
  if (is_answered_) return MHD_YES;
  try {
    // Its length was not told: nobody needs to hear why.
    if (request_.body.size() + size > options.max_body) return MHD_NO;
    request_.body.append(data, size);
  } catch (...) {
    return MHD_NO;
  }
  return MHD_YES;
}

MHD_Result MicrohttpdRequest::Answer(const Listener::Handler& handler) noexcept {
  if (is_answered_) return MHD_YES;
  watched_->BeginWorking();
  try {
    if (!HasTrustedCertificate()) {
      return Send(Text(MHD_HTTP_FORBIDDEN,
                       "this server asks for a certificate that its authority signed "
                       "(network.tls_client_ca): have your browser show one\n"));
    }
    Response response;
    try {
      response = handler(request_);
    } catch (...) {
      response = Text(MHD_HTTP_INTERNAL_SERVER_ERROR, std::string(CaughtStatus().message()) + "\n");
    }
    return Send(std::move(response));
  } catch (...) {
    return MHD_NO;
  }
}

bool MicrohttpdRequest::HasTrustedCertificate() const {
  if (!wants_certificate_) return true;
  unsigned trouble = 0;
  const gnutls_session_t session = SessionOf(connection_);
  std::string purpose = GNUTLS_KP_TLS_WWW_CLIENT;  // A server's certificate makes no client.
  gnutls_typed_vdata_st wanted = {GNUTLS_DT_KEY_PURPOSE_OID,
                                  reinterpret_cast<unsigned char*>(purpose.data()), 0};
  return session != nullptr &&
         gnutls_certificate_verify_peers(session, &wanted, 1, &trouble) == GNUTLS_E_SUCCESS &&
         trouble == 0;
}

MHD_Result MicrohttpdRequest::Send(Response response) {
  response_ = std::move(response);
  is_answered_ = true;
  uint64_t size = MHD_SIZE_UNKNOWN;
  if (response_.source == nullptr) {
    piece_ = std::move(response_.body);
    size = piece_.size();
  }
  MHD_Response* const sent =
      MHD_create_response_from_callback(size, kPieceBytes, SendMore, this, nullptr);
  if (sent == nullptr) return MHD_NO;
  for (const auto& [name, value] : response_.headers) {
    MHD_add_response_header(sent, name.c_str(), value.c_str());  // Nothing with a line's end.
  }
  const MHD_Result queued =
      MHD_queue_response(connection_, static_cast<unsigned>(response_.code), sent);
  MHD_destroy_response(sent);
  watched_->BeginSending();
  return queued;
}

ssize_t MicrohttpdRequest::SendMore(void* self, uint64_t, char* to, size_t most) {
  return static_cast<MicrohttpdRequest*>(self)->SendMore(to, most);
}

ssize_t MicrohttpdRequest::SendMore(char* to, size_t most) noexcept {
  watched_->BeginWorking();
  while (sent_ == piece_.size()) {
    const Source::Next next = TakePiece();
    if (next == Source::Next::kBroken) return MHD_CONTENT_READER_END_WITH_ERROR;
    if (next == Source::Next::kEnd) {
      watched_->BeginSending();
      return MHD_CONTENT_READER_END_OF_STREAM;
    }
  }
  const size_t size = std::min({most, piece_.size() - sent_, kPieceBytes});
  std::memcpy(to, piece_.data() + sent_, size);
  sent_ += size;
  watched_->BeginSending();
  return static_cast<ssize_t>(size);
}

Source::Next MicrohttpdRequest::TakePiece() noexcept {
  if (response_.source == nullptr) return Source::Next::kEnd;
  piece_.clear();
  sent_ = 0;
  try {
    return response_.source->Take(&piece_);
  } catch (...) {
    return Source::Next::kBroken;
  }
}

}  // namespace isthmus::http
