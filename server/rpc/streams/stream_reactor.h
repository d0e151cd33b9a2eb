// A stream as an actor: what happens to it is dealt with one thing at a time, on an executor's
// threads, and no thread waits for its client.
#pragma once

#include <absl/status/status.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/server_callback.h>

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "core/caught.h"
#include "server/rpc/streams/strand.h"
#include "server/rpc/streams/stream_host.h"

namespace isthmus::rpc {

// `Base` is gRPC's reactor of the stream: of ByteBuffers, read, and perhaps written. gRPC's own
// threads only put down what happened. Everything protected is for the strand alone.
template <typename Base>
class StreamReactor : public Base,
                      public StoppableStream,
                      public std::enable_shared_from_this<StreamReactor<Base>> {
 public:
  // Lives until gRPC is done with it. `rpc` is the method's bare name.
  template <typename Reactor, typename... Arguments>
  static Reactor* Begin(StreamHost* host, grpc::CallbackServerContext* context,
                        Arguments&&... arguments) {
    auto reactor = std::make_shared<Reactor>(host, context, std::forward<Arguments>(arguments)...);
    static_cast<StreamReactor*>(reactor.get())->self_ = reactor;
    reactor->Post([reactor = reactor.get()] { reactor->LetIn(); });
    host->Enter(reactor.get());
    return reactor.get();
  }

  void Stop() final {
    Post([this] { OnStop(); });
  }
  void OnReadDone(bool ok) final {
    Post([this, ok] {
      reading_ = false;
      timer_.Disarm();
      if (ok) OnMessage(std::move(incoming_));
      if (!ok) OnReadsDone();
    });
  }
  void OnCancel() final {
    Post([this] { End(absl::CancelledError("the client went away")); });
  }
  void OnDone() final {
    host_.Leave(this);
    const auto self = std::move(self_);  // Tasks posted already may hold it for a moment more.
  }

 protected:
  StreamReactor(StreamHost* host, Executor* executor, grpc::CallbackServerContext* context,
                const char* rpc)
      : host_(*host),
        context_(*context),
        rpc_(rpc),
        strand_(std::make_shared<Strand>(executor)),
        timer_(&host->watchdog, [this] { Post([this] { End(late_); }); }) {}

  // From any thread: the task runs on the strand, unless the stream has ended by then. What it
  // throws ends the stream.
  void Post(std::function<void()> task) {
    auto self = this->weak_from_this().lock();
    if (self == nullptr) return;
    const auto strand = strand_;  // The task may be done, and all this gone, before Post returns.
    strand->Post([self = std::move(self), task = std::move(task)] { self->Run(task); });
  }

  // A message has come; the next is read when asked for.
  virtual void OnMessage(grpc::ByteBuffer message) = 0;
  // No more come: the client has said all, or is gone (then the stream ends soon).
  virtual void OnReadsDone() = 0;
  // The server stops.
  virtual void OnStop() { End(absl::UnavailableError("the server is shutting down; try again")); }
  // Before the stream ends, to let go of what it holds elsewhere.
  virtual void OnEnd() {}

  // One at a time.
  void ReadNext() {
    if (ended_ || reading_) return;
    reading_ = true;
    this->StartRead(&incoming_);
  }
  bool reading() const { return reading_; }
  // Ends the stream with `why` unless a message comes within that time.
  void GiveTime(std::chrono::milliseconds time, absl::Status why) {
    late_ = std::move(why);
    timer_.Arm(time);
  }

  // Ends the time given: the event came about by other means than a message.
  void TakeNoTime() { timer_.Disarm(); }

  // Nothing of the call may be touched after it.
  void End(const absl::Status& status) {
    if (ended_) return;
    ended_ = true;
    timer_.Disarm();
    try {
      OnEnd();
    } catch (...) {
      // Things that were held elsewhere go with the stream.
    }
    const grpc::Status answer =
        ToGrpc(host_.gate.End(rpc_, status, context_, call_ ? &*call_ : nullptr, token_, begun_));
    call_.reset();
    this->Finish(answer);
  }
  bool ended() const { return ended_; }

  const Call& call() const { return *call_; }
  StreamHost& host() const { return host_; }

 private:
  void Run(const std::function<void()>& task) {
    if (ended_) return;
    try {
      task();
    } catch (...) {
      End(CaughtStatus());
    }
  }

  void LetIn() {
    auto call = host_.gate.Admit(context_, rpc_, &token_);
    if (!call.ok()) return End(call.status());
    call_.emplace(*std::move(call));
    call_->OnEnd([weak = this->weak_from_this()](const absl::Status& why) {
      if (auto self = weak.lock()) self->Post([raw = self.get(), why] { raw->End(why); });
    });
    GiveTime(host_.options.first_message,
             absl::DeadlineExceededError("nothing came on this stream: open it when there is "
                                         "something to send"));
    ReadNext();
  }

  StreamHost& host_;
  grpc::CallbackServerContext& context_;
  const char* const rpc_;
  const Stopwatch begun_;
  std::string token_;  // The name of the one that came, if it holds.
  const std::shared_ptr<Strand> strand_;
  std::shared_ptr<StreamReactor> self_;  // Until OnDone.
  std::optional<Call> call_;
  grpc::ByteBuffer incoming_;
  bool reading_ = false, ended_ = false;
  absl::Status late_;
  Watchdog::Timer timer_;  // Last: it fires into the rest.
};

}  // namespace isthmus::rpc
