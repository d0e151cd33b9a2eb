#include "tests/server/http/conversation.h"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>

namespace isthmus::http {
namespace {

std::string JoinChunks(const std::string& chunks, bool* is_whole) {
  std::string body;
  for (size_t at = 0;;) {
    const size_t end = chunks.find("\r\n", at);
    if (end == std::string::npos) return body;
    const size_t size = std::strtoul(chunks.substr(at, end - at).c_str(), nullptr, 16);
    if (size == 0) {
      *is_whole = chunks.compare(at, end - at, "0") == 0;
      return body;
    }
    body += chunks.substr(end + 2, size);
    at = end + 2 + size + 2;
    if (at > chunks.size()) return body;
  }
}

}  // namespace

Reply::Reply(const std::string& raw) {
  const size_t end = raw.find("\r\n\r\n");
  if (!raw.starts_with("HTTP/1.1 ") || end == std::string::npos) return;
  code = std::atoi(raw.c_str() + 9);
  for (size_t at = raw.find("\r\n") + 2; at < end;) {
    const size_t line_end = raw.find("\r\n", at), colon = raw.find(": ", at);
    std::string name = raw.substr(at, colon - at);
    std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
    headers[name] = raw.substr(colon + 2, line_end - colon - 2);
    at = line_end + 2;
  }
  body = raw.substr(end + 4);
  if (headers["transfer-encoding"] == "chunked") {
    body = JoinChunks(body, &is_whole);
  } else {
    is_whole = headers["content-length"] == std::to_string(body.size());
  }
}

Conversation::Conversation(const std::string& address)
    : file_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  const timeval longest = {20, 0};
  setsockopt(file_, SOL_SOCKET, SO_RCVTIMEO, &longest, sizeof(longest));
  setsockopt(file_, SOL_SOCKET, SO_SNDTIMEO, &longest, sizeof(longest));
  sockaddr_in to = {};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  if (connect(file_, reinterpret_cast<sockaddr*>(&to), sizeof(to)) != 0) HangUp();
}

bool Conversation::Send(const std::string& text) {
  size_t sent = 0;
  while (sent < text.size()) {
    const ssize_t n = send(file_, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
    if (n <= 0) return false;
    sent += static_cast<size_t>(n);
  }
  return true;
}

std::string Conversation::ReadUntil(const std::string& mark) {
  char bytes[16384];
  for (;;) {
    const size_t found = mark.empty() ? std::string::npos : unread_.find(mark);
    const ssize_t n = found == std::string::npos ? recv(file_, bytes, sizeof(bytes), 0) : 0;
    if (n > 0) {
      unread_.append(bytes, static_cast<size_t>(n));
      continue;
    }
    const size_t size = found == std::string::npos ? unread_.size() : found + mark.size();
    std::string read = unread_.substr(0, size);
    unread_.erase(0, size);
    return read;
  }
}

std::string Conversation::ReadAll() { return ReadUntil(""); }

void Conversation::HangUp() {
  if (file_ >= 0) close(file_);
  file_ = -1;
}

int Conversation::port() const {
  sockaddr_in own = {};
  socklen_t size = sizeof(own);
  getsockname(file_, reinterpret_cast<sockaddr*>(&own), &size);
  return ntohs(own.sin_port);
}

Reply Ask(const std::string& address, const std::string& method, const std::string& target,
          const std::string& headers, const std::string& body) {
  Conversation conversation(address);
  std::string request = method + " " + target + " HTTP/1.1\r\nConnection: close\r\n" + headers;
  if (headers.find("Host: ") == std::string::npos) request += "Host: " + address + "\r\n";
  if (!body.empty()) request += "Content-Length: " + std::to_string(body.size()) + "\r\n";
  conversation.Send(request + "\r\n" + body);
  return Reply(conversation.ReadAll());
}

}  // namespace isthmus::http
