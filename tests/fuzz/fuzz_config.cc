// Any text, taken for the server's configuration; settings that are understood must mean the same
// once they were printed.
#include <cstdint>
#include <cstdlib>
#include <string>

#include "server/main/config.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace isthmus::server;
  const auto config = ParseConfig(std::string(reinterpret_cast<const char*>(data), size));
  if (!config.ok()) return 0;
  const std::string printed = PrintConfig(*config);
  const auto again = ParseConfig(printed);
  if (!again.ok() || PrintConfig(*again) != printed) std::abort();
  return 0;
}
