// Scans for servers that do not read the newest version of quantised data. Private to the library.
#pragma once

#include <cstdint>

#include "client/library/stream/scan_source.h"

namespace isthmus::client {

// The request, or where its cloud is of a later version than the server's
// Session.quantized_version, one of version 1 with the same points, bit by bit. What cannot be read
// stays as it is; the server says what is wrong with it. Thread safe.
ScanSource::Request ForServer(ScanSource::Request request, uint32_t quantized_version);

}  // namespace isthmus::client
