// A client of HTTP that says byte by byte what the test wants, and the answers that it reads.
#pragma once

#include <map>
#include <string>

namespace isthmus::http {

// A whole answer, as it came over the wire.
struct Reply {
  explicit Reply(const std::string& raw);

  int code = 0;                                // 0: there was none.
  std::map<std::string, std::string> headers;  // Names in lower case.
  std::string body;                            // Put together, where it came in chunks.
  bool is_whole = false;                       // As its length, or the last chunk, says.
};

// One connection; every wait ends after 20 s.
class Conversation {
 public:
  // To "host:port" on this machine.
  explicit Conversation(const std::string& address);
  ~Conversation() { HangUp(); }
  Conversation(const Conversation&) = delete;
  Conversation& operator=(const Conversation&) = delete;

  // True if all of it left.
  bool Send(const std::string& text);
  // Everything since the last read, until `mark` is in it or the server hangs up.
  std::string ReadUntil(const std::string& mark);
  std::string ReadAll();
  void HangUp();
  int port() const;  // This side's port.

 private:
  int file_ = -1;
  std::string unread_;
};

// One request with these further headers ("Name: value\r\n"...) on a connection of its own.
Reply Ask(const std::string& address, const std::string& method, const std::string& target,
          const std::string& headers = "", const std::string& body = "");

}  // namespace isthmus::http
