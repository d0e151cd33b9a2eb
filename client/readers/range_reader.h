// A part of a recording.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "client/readers/scan_reader.h"

namespace isthmus::readers {

// The scans `from` to `to` (included; counted from 0) of another reader's, errors counted as scans.
// What comes before is read and left out.
std::unique_ptr<ScanReader> TakeRange(std::unique_ptr<ScanReader> reader, uint64_t from,
                                      std::optional<uint64_t> to);

}  // namespace isthmus::readers
