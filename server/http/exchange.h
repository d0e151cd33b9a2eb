// A request over HTTP and its answer.
#pragma once

#include <absl/strings/string_view.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace isthmus::http {

using Fields = std::vector<std::pair<std::string, std::string>>;

struct Request {
  std::string method = {};  // "GET".
  std::string path = {};    // "/a b": without escapes and query.
  Fields headers = {};
  Fields query = {};  // Without escapes.
  std::string body = {};
  std::string peer = {};  // As gRPC names it: "ipv4:127.0.0.1:4711".
  bool is_tls = false;
  // True if the client has closed the connection; a handler that takes long asks now and then. Set
  // while the request is answered.
  std::function<bool()> gone = [] { return false; };

  // The header of that name in any case; values of one that came several times are joined by ", ".
  std::optional<std::string> Header(absl::string_view name) const;
  // The first one.
  std::optional<std::string> Query(absl::string_view name) const;
  std::optional<std::string> Cookie(absl::string_view name) const;
};

// An answer's body that is made while it is sent, by the thread of its connection.
class Source {
 public:
  enum class Next {
    kPiece,
    kEnd,
    kBroken,  // The connection is cut, so that the client does not take it for whole.
  };

  virtual ~Source() = default;
  // Waits for the next piece, which may be empty. An exception is kBroken.
  virtual Next Take(std::string* piece) = 0;
};

struct Response {
  int code = 200;
  Fields headers = {};  // But for length and connection.
  std::string body = {};
  std::unique_ptr<Source> source = nullptr;  // In place of `body`.

  void Set(absl::string_view name, absl::string_view value) {
    headers.emplace_back(std::string(name), std::string(value));
  }
};

Response Text(int code, std::string text);

}  // namespace isthmus::http
