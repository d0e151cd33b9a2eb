// The source of the scans that a sender sends, and the sink of their acknowledgements. Private to
// the library.
#pragma once

#include <absl/status/status.h>
#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "client/library/stream/session_link.h"
#include "isthmus/v1/session_service.pb.h"

namespace isthmus::client {

struct OpenedSession {
  std::string id;
  int64_t created_ns = 0;  // 0: not known.
};

// Two of one name are told apart by when they were opened: a server with another map folder gives
// names again.
inline bool IsAnother(const v1::Session& known, const OpenedSession& opened) {
  return opened.created_ns != 0 && known.created_ns() != opened.created_ns;
}

// Thread safe. The sender calls it without locks of its own.
class ScanSource {
 public:
  using Request = std::shared_ptr<const v1::StreamScansRequest>;
  // Makes one attempt at a call that the server answers at once, or at one that takes its time.
  enum class Duration { kShort, kLong };
  using Attempt = std::function<absl::Status(SessionCall&)>;
  using Ask = std::function<absl::Status(Duration, const Attempt&)>;

  virtual ~ScanSource() = default;

  // The session, opened if that has not happened.
  virtual absl::StatusOr<OpenedSession> OpenSession(const Ask& ask) = 0;
  // A new link begins, to a server that stands so; of a session that it does not know, `known` has
  // no id. True if that acknowledged scans. An error ends the link.
  virtual absl::StatusOr<bool> BeginLink(const v1::Session& known) = 0;
  // The next scan; waits for one. Null when there will be none on this link.
  virtual Request NextRequest() = 0;
  // The scan is larger than the server takes: what to send in its place, under its number. Null
  // where nothing can be for now: the link ends.
  virtual Request InPlaceOf(const Request& too_large, uint64_t most_bytes) = 0;
  // The link has ended: Next returns null until the next BeginLink.
  virtual void InterruptLink() = 0;
  // True for an acknowledgement that brought the stream on.
  virtual bool HandleResponse(const v1::StreamScansResponse& response) = 0;
  // True if everything was acknowledged and no more will come.
  virtual bool complete() const = 0;
  // After that; attempted again after a link that was lost.
  virtual absl::Status ConcludeSession(const Ask& ask) = 0;
  // A link was lost and will be opened again.
  virtual void OnLinkLost() = 0;
  // For people: how the link fares.
  virtual void Tell(const std::string& news) = 0;
  // The sender's last word.
  virtual void OnEnd(const absl::Status& status) = 0;

 protected:
  // Has the session finished, with its scans up to `last_sequence`.
  static absl::Status AskToFinish(const Ask& ask, const std::string& session,
                                  uint64_t last_sequence, v1::Session* finished) {
    v1::FinishSessionRequest request;
    request.set_session(session);
    request.set_last_sequence(last_sequence);
    return ask(Duration::kLong,
               [&](SessionCall& call) { return call.FinishSession(request, finished); });
  }
};

}  // namespace isthmus::client
