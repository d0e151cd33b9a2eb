#include "core/address.h"

#include <absl/strings/ascii.h>
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_split.h>
#include <arpa/inet.h>

#include <algorithm>

namespace isthmus {
namespace {

constexpr int kHighestPort = 65535;

bool IsOfSocketFile(const std::string& address) {
  return address.starts_with("unix:") || address.starts_with("unix-abstract:");
}

absl::Status Wrong(const std::string& address, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("\"", address, "\" is no address of a server: ",
                                                 what, "; write HOST:PORT, as in localhost:50051"));
}

}  // namespace

absl::Status CheckAddress(const std::string& address, PortZero zero) {
  const size_t colon = address.rfind(':');
  if (IsOfSocketFile(address)) {
    return address.back() == ':' ? Wrong(address, "it names no file") : absl::OkStatus();
  }
  const size_t bracket = address.rfind(']');
  if (colon == std::string::npos || (bracket != std::string::npos && bracket > colon)) {
    return Wrong(address, "it names no port");
  }
  if (colon == 0) return Wrong(address, "it names no host");
  const std::string port = address.substr(colon + 1);
  const bool is_number = !port.empty() && std::ranges::all_of(port, [](char letter) {
    return '0' <= letter && letter <= '9';
  });
  if (!is_number) return Wrong(address, absl::StrCat("the port \"", port, "\" is no number"));
  const int lowest = zero == PortZero::kAnyFreeOne ? 0 : 1;
  int number = 0;
  if (!absl::SimpleAtoi(port, &number) || number < lowest || number > kHighestPort) {
    return Wrong(address, absl::StrCat("ports are ", lowest, " to ", kHighestPort));
  }
  return absl::OkStatus();
}

std::vector<std::string> SplitAddresses(const std::string& addresses) {
  std::vector<std::string> split = absl::StrSplit(addresses, ',');
  for (std::string& address : split) absl::StripAsciiWhitespace(&address);
  return split;
}

absl::Status CheckAddresses(const std::string& addresses) {
  for (const std::string& address : SplitAddresses(addresses)) {
    if (absl::Status status = CheckAddress(address); !status.ok()) return status;
  }
  return absl::OkStatus();
}

bool IsThisMachine(const std::string& address) {
  if (IsOfSocketFile(address)) return true;
  const std::string host = address.substr(0, address.rfind(':'));
  if (host == "localhost" || host == "[::1]" || host == "::1") return true;
  in_addr number = {};
  constexpr uint32_t kLoopbackNet = 127;
  return inet_pton(AF_INET, host.c_str(), &number) == 1 &&
         ntohl(number.s_addr) >> 24 == kLoopbackNet;
}

}  // namespace isthmus
