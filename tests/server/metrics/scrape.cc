#include "tests/server/metrics/scrape.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <limits>
#include <sstream>

namespace isthmus::metrics {
namespace {

// `text`: a="b",c="d".
std::map<std::string, std::string> LabelsOf(const std::string& text) {
  std::map<std::string, std::string> labels;
  for (size_t at = 0; at < text.size();) {
    const size_t equals = text.find("=\"", at), end = text.find('"', equals + 2);
    if (equals == std::string::npos || end == std::string::npos) break;
    labels[text.substr(at, equals - at)] = text.substr(equals + 2, end - equals - 2);
    at = end + 2;
  }
  return labels;
}

}  // namespace

std::string Ask(const std::string& address, const std::string& request_line) {
  const int connection = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const timeval longest = {20, 0};
  setsockopt(connection, SOL_SOCKET, SO_RCVTIMEO, &longest, sizeof(longest));
  sockaddr_in to = {};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  to.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  std::string answer;
  if (connect(connection, reinterpret_cast<sockaddr*>(&to), sizeof(to)) == 0) {
    const std::string request = request_line + " HTTP/1.1\r\nHost: test\r\n\r\n";
    send(connection, request.data(), request.size(), MSG_NOSIGNAL);
    char bytes[4096];
    for (ssize_t n = 0; (n = recv(connection, bytes, sizeof(bytes), 0)) > 0;) {
      answer.append(bytes, static_cast<size_t>(n));
    }
  }
  close(connection);
  return answer;
}

Scrape::Scrape(const std::string& answer) {
  const size_t headers = answer.find("\r\n\r\n");
  std::istringstream lines(headers == std::string::npos ? answer : answer.substr(headers + 4));
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("# HELP ")) families_.insert(line.substr(7, line.find(' ', 7) - 7));
    if (line.empty() || line[0] == '#') continue;
    const size_t space = line.rfind(' '), brace = line.find('{');
    Sample& sample = samples_.emplace_back();
    sample.name = line.substr(0, std::min(space, brace));
    if (brace != std::string::npos) {
      sample.labels = LabelsOf(line.substr(brace + 1, line.rfind('}') - brace - 1));
    }
    sample.value = std::stod(line.substr(space + 1));
  }
}

Scrape Scrape::Of(const std::string& address) { return Scrape(Ask(address, "GET /metrics")); }

double Scrape::Sum(const std::string& name,
                   const std::map<std::string, std::string>& labels) const {
  double sum = 0;
  bool is_there = false;
  for (const Sample& sample : samples_) {
    const bool fits = std::ranges::all_of(labels, [&](const auto& label) {
      const auto found = sample.labels.find(label.first);
      return found != sample.labels.end() && found->second == label.second;
    });
    if (sample.name != name || !fits) continue;
    is_there = true;
    sum += sample.value;
  }
  return is_there ? sum : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace isthmus::metrics
