// Submaps on their way into a session, which is opened with the first.
#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <map>
#include <string>

#include "client/library/client.h"
#include "core/map/submap.h"

namespace isthmus::cli {

// The session that the submaps go to.
struct SubmapTarget {
  SessionRequest request;
  std::string session;  // To go on in; empty: the one that the same submaps began, else a new one.
};

// Submaps that the server has are not sent again: the same submaps, sent once more from the first
// on, go on where they were cut off. Not thread safe.
class SubmapSender {
 public:
  SubmapSender(client::Client& client, SubmapTarget target);

  // In order of index. AlreadyExists where the server has another submap under the index, or the
  // session is finished and lacks it; else the server's errors.
  absl::Status Send(SubmapUpload submap);
  // Finishes the session, if there is one.
  absl::Status Finish();

  const SessionId& session() const { return session_; }  // Empty before the first submap.
  bool was_finished() const { return was_finished_; }    // The session, before.
  uint64_t submaps() const { return submaps_; }          // In all; of them `before` were there.
  uint64_t before() const { return before_; }
  uint64_t sent_bytes() const { return sent_bytes_; }  // Bytes of clouds.

 private:
  absl::Status Open(const SubmapUpload& first);

  client::Client& client_;
  const SubmapTarget target_;
  SessionId session_;
  bool was_finished_ = false;
  uint64_t submaps_ = 0, before_ = 0, sent_bytes_ = 0;
  std::map<uint32_t, SubmapInfo> known_;  // Submaps at the server at the beginning.
};

}  // namespace isthmus::cli
