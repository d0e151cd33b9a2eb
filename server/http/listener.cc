#include "server/http/listener.h"

#include <absl/strings/str_cat.h>
#include <fcntl.h>
#include <microhttpd.h>
#include <unistd.h>

#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/address.h"
#include "core/concurrency/mutex.h"
#include "core/io/listening_socket.h"
#include "server/http/connection_watch.h"
#include "server/http/microhttpd_request.h"

namespace isthmus::http {
namespace {

// Text from libmicrohttpd ends at a zero byte, so a zero byte in an address would hide the rest of
// it: such an address stays escaped, and is nobody's.
size_t Unescape(void* /*self*/, MHD_Connection* /*connection*/, char* text) {
  if (std::strstr(text, "%00") != nullptr) return std::strlen(text);
  return MHD_http_unescape(text);
}

class MhdListener final : public Listener {
 public:
  MhdListener(const ListenerOptions& options, Handler handler)
      : options_(options),
        handler_(std::move(handler)),
        watch_(options.request_time, options.piece_time) {}
  ~MhdListener() override;

  absl::Status Listen();
  std::string address() const override { return address_; }

 private:
  static MHD_Result OnRequest(void* self, MHD_Connection* connection, const char* path,
                              const char* method, const char*, const char* data, size_t* size,
                              void** request);
  static void OnEnd(void* self, MHD_Connection* connection, void** request,
                    MHD_RequestTerminationCode);
  static void OnConnection(void* self, MHD_Connection* connection, void** watched,
                           MHD_ConnectionNotificationCode what);
  static Connection* ConnectionOf(MHD_Connection* connection);

  // Takes no more connections.
  static void Quiesce(MHD_Daemon* daemon);
  // Ends a quiet one with its connections.
  void End(MHD_Daemon* daemon);
  // Serves connections of the socket by these keys from now on; null: it cannot.
  MHD_Daemon* Serve(const tls::KeyTexts& keys);
  MHD_Daemon* ServeAt(int socket, const tls::KeyTexts& keys);  // Closes it if all goes well.
  void LookUntilStopped();
  void LookAtKeys();

  const ListenerOptions options_;
  const Handler handler_;
  ConnectionWatch watch_;
  std::string address_;
  tls::KeyTexts keys_;  // Keys of `daemon_`; like the next ones the thread's own, once it runs.
  std::string stamp_;
  MHD_Daemon* daemon_ = nullptr;
  io::File socket_;                 // Each daemon accepts from a copy.
  std::vector<MHD_Daemon*> older_;  // Daemons with older keys, for their connections.
  Mutex mutex_;
  CondVar stop_;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread looks_;
};

MhdListener::~MhdListener() {
  {
    MutexLock lock(&mutex_);
    stopped_ = true;
    stop_.SignalAll();
  }
  if (looks_.joinable()) looks_.join();
  for (MHD_Daemon* const older : older_) End(older);
  if (daemon_ == nullptr) return;
  Quiesce(daemon_);
  End(daemon_);
}

void MhdListener::Quiesce(MHD_Daemon* daemon) {
  if (const MHD_socket old = MHD_quiesce_daemon(daemon); old != MHD_INVALID_SOCKET) close(old);
}

// Nobody is connected any more when the library stops: version 0.9.75 queues no answer while it
// does, but sends the one that nonsense gets, and crashes.
void MhdListener::End(MHD_Daemon* daemon) {
  watch_.CutAll(daemon, kEndTime);
  MHD_stop_daemon(daemon);
}

absl::Status MhdListener::Listen() {
  stamp_ = tls::StampOf(options_.tls);
  auto keys = tls::ReadKeyFiles(options_.tls);
  if (!keys.ok()) return keys.status();
  keys_ = *std::move(keys);
  // The library takes one of several addresses that a name has.
  const size_t colon = options_.listen.rfind(':');
  const std::string host = options_.listen.substr(0, colon), port = options_.listen.substr(colon);
  auto sockets = io::ListenAt(absl::StrCat(host == "localhost" ? "127.0.0.1" : host, port));
  if (!sockets.ok()) {
    return absl::UnavailableError(
        absl::StrCat("cannot listen at ", options_.listen, " (", sockets.status().message(),
                     "): the address is in use, or not one of this machine; name another one in ",
                     options_.setting));
  }
  socket_ = std::move(sockets->front());
  address_ = absl::StrCat(host, ":", io::PortOf(socket_));
  daemon_ = Serve(keys_);
  if (daemon_ == nullptr) {
    return absl::UnavailableError(
        absl::StrCat("cannot serve at ", options_.listen,
                     keys_.key.empty() ? ": there are no threads or files left for it"
                                       : ": the certificate or its key is of no use for TLS"));
  }
  looks_ = std::thread([this] { LookUntilStopped(); });
  return absl::OkStatus();
}

MHD_Daemon* MhdListener::Serve(const tls::KeyTexts& keys) {
  const int copy = fcntl(socket_.descriptor(), F_DUPFD_CLOEXEC, 0);
  if (copy < 0) return nullptr;
  MHD_Daemon* const daemon = ServeAt(copy, keys);
  if (daemon == nullptr) close(copy);
  return daemon;
}

MHD_Daemon* MhdListener::ServeAt(int socket, const tls::KeyTexts& keys) {
  const auto text = [](const std::string& pem) {
    return static_cast<void*>(const_cast<char*>(pem.c_str()));
  };
  std::vector<MHD_OptionItem> items = {
      {MHD_OPTION_LISTEN_SOCKET, socket, nullptr},
      {MHD_OPTION_CONNECTION_LIMIT, static_cast<intptr_t>(options_.connections), nullptr},
      {MHD_OPTION_PER_IP_CONNECTION_LIMIT, static_cast<intptr_t>(options_.connections_per_address),
       nullptr},
      {MHD_OPTION_CONNECTION_MEMORY_LIMIT, static_cast<intptr_t>(kConnectionBytes), nullptr},
      {MHD_OPTION_UNESCAPE_CALLBACK, reinterpret_cast<intptr_t>(Unescape), nullptr},
      {MHD_OPTION_NOTIFY_COMPLETED, reinterpret_cast<intptr_t>(OnEnd), this},
      {MHD_OPTION_NOTIFY_CONNECTION, reinterpret_cast<intptr_t>(OnConnection), this}};
  unsigned flags = MHD_USE_POLL_INTERNAL_THREAD | MHD_USE_THREAD_PER_CONNECTION | MHD_USE_ITC;
  if (!keys.key.empty()) {
    flags |= MHD_USE_TLS;
    items.push_back({MHD_OPTION_HTTPS_MEM_CERT, 0, text(keys.certificate)});
    items.push_back({MHD_OPTION_HTTPS_MEM_KEY, 0, text(keys.key)});
    static const std::string versions = "NORMAL:-VERS-TLS1.0:-VERS-TLS1.1";
    items.push_back({MHD_OPTION_HTTPS_PRIORITIES, 0, text(versions)});
    if (!keys.client_ca.empty()) {
      items.push_back({MHD_OPTION_HTTPS_MEM_TRUST, 0, text(keys.client_ca)});
    }
  }
  items.push_back({MHD_OPTION_END, 0, nullptr});
  return MHD_start_daemon(flags, 0, nullptr, nullptr, OnRequest, this, MHD_OPTION_ARRAY,
                          items.data(), MHD_OPTION_END);
}

void MhdListener::LookUntilStopped() {
  MutexLock lock(&mutex_);
  while (!stopped_) {
    stop_.WaitFor(&mutex_, kLookInterval);
    if (stopped_) return;
    mutex_.Unlock();
    watch_.CutSlow();
    LookAtKeys();
    mutex_.Lock();
  }
}

void MhdListener::LookAtKeys() {
  if (keys_.key.empty()) return;
  while (!older_.empty()) {
    const auto* const info =
        MHD_get_daemon_info(older_.front(), MHD_DAEMON_INFO_CURRENT_CONNECTIONS);
    if (older_.size() == 1 && info != nullptr && info->num_connections > 0) break;
    End(older_.front());
    older_.erase(older_.begin());
  }
  std::string stamp = tls::StampOf(options_.tls);
  if (stamp == stamp_) return;
  stamp_ = std::move(stamp);
  auto keys = tls::ReadKeyFiles(options_.tls);
  if (!keys.ok() || *keys == keys_) return;  // Half written: the other half will be seen, too.
  // Two accept from one socket for a moment.
  MHD_Daemon* const next = Serve(*keys);
  if (next == nullptr) return;  // On with those before.
  Quiesce(daemon_);
  keys_ = *std::move(keys);
  older_.push_back(std::exchange(daemon_, next));
}

Connection* MhdListener::ConnectionOf(MHD_Connection* connection) {
  const auto* const info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
  return info == nullptr ? nullptr : static_cast<Connection*>(info->socket_context);
}

void MhdListener::OnConnection(void* self, MHD_Connection* connection, void** watched,
                               MHD_ConnectionNotificationCode what) {
  ConnectionWatch& watch = static_cast<MhdListener*>(self)->watch_;
  if (what == MHD_CONNECTION_NOTIFY_CLOSED) {
    if (*watched != nullptr) watch.Remove(static_cast<Connection*>(*watched));
    *watched = nullptr;
    return;
  }
  const auto* const file = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
  const int descriptor = file == nullptr ? -1 : file->connect_fd;  // The next call takes its place.
  const auto* const owner = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_DAEMON);
  try {
    *watched = descriptor < 0 || owner == nullptr ? nullptr : watch.Add(descriptor, owner->daemon);
  } catch (...) {
    *watched = nullptr;  // Its requests are refused.
  }
}

MHD_Result MhdListener::OnRequest(void* self, MHD_Connection* connection, const char* path,
                                  const char* method, const char*, const char* data, size_t* size,
                                  void** request) {
  const auto& listener = *static_cast<const MhdListener*>(self);
  auto* served = static_cast<MicrohttpdRequest*>(*request);
  if (served == nullptr) {
    Connection* const watched = ConnectionOf(connection);
    if (watched == nullptr) return MHD_NO;
    try {
      served = new MicrohttpdRequest(connection, watched, path, method);
    } catch (...) {
      return MHD_NO;
    }
    *request = served;  // Until OnEnd.
    return served->Begin(listener.options_);
  }
  if (*size == 0) return served->Answer(listener.handler_);
  const MHD_Result taken = served->Take(data, *size, listener.options_);
  *size = 0;
  return taken;
}

void MhdListener::OnEnd(void*, MHD_Connection* connection, void** request,
                        MHD_RequestTerminationCode) {
  delete static_cast<MicrohttpdRequest*>(*request);
  *request = nullptr;
  if (Connection* const watched = ConnectionOf(connection); watched != nullptr)
    watched->BeginReceiving();
}

}  // namespace

absl::Status CheckTcpAddress(const std::string& setting, const std::string& listen) {
  if (listen.starts_with("unix") || listen.find(',') != std::string::npos) {
    return absl::InvalidArgumentError(absl::StrCat("HTTP is served over TCP at one address: write ",
                                                   setting, " as HOST:PORT, not \"", listen, "\""));
  }
  const absl::Status status = CheckAddress(listen, PortZero::kAnyFreeOne);
  if (status.ok()) return status;
  return absl::Status(status.code(), absl::StrCat(setting, ": ", status.message()));
}

absl::StatusOr<std::unique_ptr<Listener>> Listener::Start(const ListenerOptions& options,
                                                          Handler handler) {
  auto listener = std::make_unique<MhdListener>(options, std::move(handler));
  if (absl::Status status = listener->Listen(); !status.ok()) return status;
  return listener;
}

}  // namespace isthmus::http
