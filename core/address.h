// HOST:PORT of a server, as a person writes it.
#pragma once

#include <absl/status/status.h>

#include <string>
#include <vector>

namespace isthmus {

// The meaning of port 0: a server may take any free port, nobody can be reached there.
enum class PortZero { kRefused, kAnyFreeOne };

// InvalidArgument, saying what is wrong with it, if the address is neither "host:port", with a port
// from 1 to 65535, nor "[::1]:port" nor "unix:path". It is not checked that the host exists.
absl::Status CheckAddress(const std::string& address, PortZero zero = PortZero::kRefused);

// "a:50051,b:50051", under which one of several servers of a map is found, as its addresses; one at
// least, of none of which is said that it is one. A socket's path has no comma then.
std::vector<std::string> SplitAddresses(const std::string& addresses);

// InvalidArgument where CheckAddress would say that of one of them.
absl::Status CheckAddresses(const std::string& addresses);

// True for addresses that only this machine reaches: of 127.0.0.0/8, [::1], localhost, and sockets
// that are files. The address must have passed CheckAddress.
bool IsThisMachine(const std::string& address);

}  // namespace isthmus
