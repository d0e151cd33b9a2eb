// The limit on the files and connections that this process may have open.
#pragma once

#include <cstdint>

namespace isthmus::server {

// Raises it as far as a process may by itself; returns what it is then.
uint64_t RaiseOpenFiles();

}  // namespace isthmus::server
