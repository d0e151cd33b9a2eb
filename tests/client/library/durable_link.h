// DurableSessions without a network: calls are functions, so that what is tested are the library's
// own threads alone, which ThreadSanitizer can follow.
#pragma once

#include <deque>
#include <memory>
#include <set>
#include <string>

#include "api/convert/session.h"
#include "client/library/stream/scan_stream_impl.h"
#include "client/library/stream/session_link.h"
#include "core/concurrency/mutex.h"
#include "tests/client/library/durable_sessions.h"

namespace isthmus::client {

// The part of a Client that tests of streams need.
class LinkedClient {
 public:
  explicit LinkedClient(std::shared_ptr<SessionLink> link) : link_(std::move(link)) {}

  absl::StatusOr<std::unique_ptr<ScanStream>> OpenSpool(const SessionRequest& session_request,
                                                        const ScanStreamOptions& options) {
    return ScanStream::Impl::Open(link_, options,
                                  {.request = convert::ToMessage(session_request), .disk = disk});
  }
  absl::StatusOr<std::unique_ptr<ScanStream>> OpenScanStream(const SessionId& id,
                                                             const ScanStreamOptions& options) {
    v1::GetSessionRequest request;
    request.set_session(id.value());
    v1::Session session;
    const absl::Status status = link_->NewCall(0)->GetSession(request, &session);
    if (!status.ok()) return status;
    return ScanStream::Impl::Open(link_, options, {.session = session});
  }
  absl::StatusOr<std::unique_ptr<ScanStream>> ResumeScanStream(const ScanStreamOptions& options) {
    return ScanStream::Impl::Open(link_, options, {});
  }

  const io::DiskCalls* disk = &io::DiskCalls::System();  // Spools lie on it.

 private:
  const std::shared_ptr<SessionLink> link_;
};

class LinkedSessions final : public DurableSessions {
 public:
  ~LinkedSessions() { Stop(); }

  void Start() {
    MutexLock lock(&wires_mutex_);
    up_ = true;
  }
  void Stop() {
    MutexLock lock(&wires_mutex_);
    up_ = false;
    for (Wire* wire : wires_) wire->End(absl::UnavailableError("the server is gone"));
  }
  // As after kill -9.
  void Crash() {
    Stop();
    Forget();
  }

  std::unique_ptr<LinkedClient> Connect(const ClientOptions& options) {
    return std::make_unique<LinkedClient>(std::make_shared<Link>(this, options));
  }

 private:
  // A scan is taken while it is written; its acknowledgement waits to be read.
  class Wire final : public ScanWire {
   public:
    explicit Wire(LinkedSessions* server) : server_(*server) {
      mute_ = server_.BeginStream();
      MutexLock lock(&server_.wires_mutex_);
      server_.wires_.insert(this);
      if (!server_.up_) End(absl::UnavailableError("there is no server"));
    }
    ~Wire() override {
      MutexLock lock(&server_.wires_mutex_);
      server_.wires_.erase(this);
    }

    bool Write(const v1::StreamScansRequest& request) override {
      if (ended()) return false;
      if (!request.session().empty()) session_ = request.session();
      if (!request.has_scan()) return true;
      if (mute_) {
        server_.Mute();
        return true;
      }
      v1::StreamScansResponse ack;
      absl::Status status = server_.Take(session_, request.scan(), ack);
      if (status.ok() && ++scans_ == server_.break_every) status = server_.Broken();
      if (!status.ok()) {
        End(status);
        return false;
      }
      MutexLock lock(&mutex_);
      acks_.push_back(ack);
      changed_.SignalAll();
      return true;
    }
    void WritesDone() override { End(mute_ ? absl::UnavailableError("ended") : absl::OkStatus()); }
    bool Read(v1::StreamScansResponse* response) override {
      MutexLock lock(&mutex_);
      while (acks_.empty() && !ended_) changed_.Wait(&mutex_);
      if (acks_.empty()) return false;
      *response = acks_.front();
      acks_.pop_front();
      return true;
    }
    absl::Status Finish() override {
      MutexLock lock(&mutex_);
      return status_;
    }

    // The first word counts.
    void End(const absl::Status& status) {
      MutexLock lock(&mutex_);
      if (ended_) return;
      ended_ = true;
      status_ = status;
      // Acknowledgements lost with the link are not read; those before its orderly end are.
      if (!status.ok()) acks_.clear();
      changed_.SignalAll();
    }

   private:
    bool ended() {
      MutexLock lock(&mutex_);
      return ended_;
    }

    LinkedSessions& server_;
    bool mute_ = false;
    std::string session_;
    int scans_ = 0;
    Mutex mutex_;
    CondVar changed_;
    std::deque<v1::StreamScansResponse> acks_ ABSL_GUARDED_BY(mutex_);
    bool ended_ ABSL_GUARDED_BY(mutex_) = false;
    absl::Status status_ ABSL_GUARDED_BY(mutex_);
  };

  class Call final : public SessionCall {
   public:
    explicit Call(LinkedSessions* server) : server_(*server) {}

    absl::Status CreateSession(const v1::CreateSessionRequest& request,
                               v1::Session* session) override {
      return server_.IfUp([&] { return server_.Create(request, session); });
    }
    absl::Status GetSession(const v1::GetSessionRequest& request, v1::Session* session) override {
      return server_.IfUp([&] { return server_.Get(request, session); });
    }
    absl::Status FinishSession(const v1::FinishSessionRequest& request,
                               v1::Session* session) override {
      return server_.IfUp([&] { return server_.Finish(request, session); });
    }
    std::unique_ptr<ScanWire> StreamScans() override {
      auto wire = std::make_unique<Wire>(&server_);
      MutexLock lock(&mutex_);
      wire_ = wire.get();
      if (cancelled_) wire_->End(absl::CancelledError("hung up"));
      return wire;
    }
    void Cancel() override {
      MutexLock lock(&mutex_);
      cancelled_ = true;
      if (wire_ != nullptr) wire_->End(absl::CancelledError("hung up"));
    }
    bool connected() const override { return true; }
    void Renew() override {}

   private:
    LinkedSessions& server_;
    Mutex mutex_;
    bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
    Wire* wire_ ABSL_GUARDED_BY(mutex_) = nullptr;
  };

  class Link final : public SessionLink {
   public:
    Link(LinkedSessions* server, const ClientOptions& options)
        : SessionLink(options), server_(*server) {}
    std::unique_ptr<SessionCall> NewCall(double) override {
      return std::make_unique<Call>(&server_);
    }

   private:
    LinkedSessions& server_;
  };

  template <typename Answer>
  absl::Status IfUp(const Answer& answer) {
    {
      MutexLock lock(&wires_mutex_);
      if (!up_) return absl::UnavailableError("there is no server");
    }
    return answer();
  }

  Mutex wires_mutex_;
  bool up_ ABSL_GUARDED_BY(wires_mutex_) = true;
  std::set<Wire*> wires_ ABSL_GUARDED_BY(wires_mutex_);
};

using TestServer = LinkedSessions;

}  // namespace isthmus::client
