// HOST:PORT of a server, as a person writes it.
#pragma once

#include <absl/status/status.h>

#include <string>

namespace isthmus {

// What a port of 0 means: a server may take any that is free, nobody can be reached there.
enum class PortZero { kRefused, kAnyFreeOne };

// InvalidArgument, saying what is wrong with it, where the address is neither "host:port", with a
// port from 1 to 65535, nor "[::1]:port" nor "unix:path". Whether there is such a host is not
// asked.
absl::Status CheckAddress(const std::string& address, PortZero zero = PortZero::kRefused);

// True for addresses that only this machine reaches: of 127.0.0.0/8, [::1], localhost, and sockets
// that are files. The address must have passed CheckAddress.
bool IsThisMachine(const std::string& address);

}  // namespace isthmus
