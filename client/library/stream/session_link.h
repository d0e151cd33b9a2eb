// The interface through which streams of scans reach a server. Private to the library.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/library/options.h"
#include "client/library/stream/wait_clock.h"
#include "core/address.h"
#include "isthmus/v1/session_service.pb.h"

namespace isthmus::client {

// DataLoss where the server says that the session has more scans than any has: they could not be
// counted on.
absl::Status CheckSession(const v1::Session& session);

// A stream of scans that is open. One thread writes, another one reads.
class ScanWire {
 public:
  virtual ~ScanWire() = default;
  // False once it is over.
  virtual bool Write(const v1::StreamScansRequest& request) = 0;
  virtual void WritesDone() = 0;
  // Waits for one; false when none will come.
  virtual bool Read(v1::StreamScansResponse* response) = 0;
  // The outcome of the stream, once reading and writing have ended.
  virtual absl::Status Finish() = 0;
};

// One attempt at one call of the session service: whichever function is called, once.
class SessionCall {
 public:
  virtual ~SessionCall() = default;
  virtual absl::Status CreateSession(const v1::CreateSessionRequest& request,
                                     v1::Session* session) = 0;
  virtual absl::Status GetSession(const v1::GetSessionRequest& request, v1::Session* session) = 0;
  virtual absl::Status FinishSession(const v1::FinishSessionRequest& request,
                                     v1::Session* session) = 0;
  // The call must outlive it.
  virtual std::unique_ptr<ScanWire> StreamScans() = 0;

  // Ends it, also one that has not begun yet. Thread safe.
  virtual void Cancel() = 0;
  // True if the connection that it goes over stands.
  virtual bool connected() const = 0;
  // Later calls do not go over that connection; with several servers, they go to the next.
  virtual void Renew() = 0;
};

// The seconds after which a server that refused a call for one of its limits wants it again;
// nothing for any other status.
std::optional<double> AskedToWait(const absl::Status& status);

// The bytes of the largest message that a server takes which refused a larger one; nothing for any
// other status.
std::optional<uint64_t> LargestMessage(const absl::Status& status);

// The way to one server, or to that of several which has the map, over as many connections as it
// takes. Thread safe.
class SessionLink {
 public:
  explicit SessionLink(const ClientOptions& options)
      : options_(options), addresses_(SplitAddresses(options.address)) {}
  virtual ~SessionLink() = default;

  // It may last so long; 0: for ever. The link must outlive it.
  virtual std::unique_ptr<SessionCall> NewCall(double timeout_s) = 0;

  const ClientOptions& options() const { return options_; }
  const std::vector<std::string>& addresses() const { return addresses_; }
  int ways() const { return static_cast<int>(addresses_.size()); }
  const WaitClock& clock() const {
    return options_.clock != nullptr ? *options_.clock : WaitClock::System();
  }
  // Repeats `attempt` while it ends in Unavailable, ResourceExhausted that says when to come again,
  // or (if `also_data_loss`) DataLoss, waiting in between.
  absl::Status Repeat(bool also_data_loss, const std::function<absl::Status()>& attempt);
  // Adds to an Unavailable status where the server was sought and what to do, and to that of a
  // message which is too large which setting says so. Others pass.
  absl::Status Explain(const absl::Status& status) const;
  void Sleep(double seconds) const;

 private:
  const ClientOptions options_;
  const std::vector<std::string> addresses_;  // One at least.
};

}  // namespace isthmus::client
