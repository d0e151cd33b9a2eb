// One request as libmicrohttpd hands it over, piece by piece, and its answer on the way back.
#pragma once

#include <microhttpd.h>

#include <cstddef>
#include <string>

#include "server/http/connection_watch.h"
#include "server/http/listener.h"

namespace isthmus::http {

// Used by the thread of its connection alone. Nothing throws: its callers are written in C.
class MicrohttpdRequest {
 public:
  MicrohttpdRequest(MHD_Connection* connection, Connection* watched, const char* path,
                    const char* method);

  // Its headers are there. Answers at once if it is too large.
  MHD_Result Begin(const ListenerOptions& options) noexcept;
  // A piece of its body came.
  MHD_Result Take(const char* data, size_t size, const ListenerOptions& options) noexcept;
  // All of it is there.
  MHD_Result Answer(const Listener::Handler& handler) noexcept;

 private:
  static ssize_t SendMore(void* self, uint64_t position, char* to, size_t most);
  ssize_t SendMore(char* to, size_t most) noexcept;
  Source::Next TakePiece() noexcept;
  bool HasTrustedCertificate() const;
  MHD_Result Send(Response response);

  MHD_Connection* const connection_;
  Connection* const watched_;
  Request request_;
  Response response_;
  std::string piece_;
  size_t sent_ = 0;  // Bytes of the piece.
  bool is_answered_ = false, wants_certificate_ = false;
};

}  // namespace isthmus::http
