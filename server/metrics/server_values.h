// The values of the server as a whole: its version, and the resources of the process.
#pragma once

#include <cstdint>
#include <string>

namespace isthmus::metrics {

class Values;

// `started_ns`: when, Unix nanoseconds.
void AddServer(const std::string& version, int64_t started_ns, Values* values);

}  // namespace isthmus::metrics
