// A reader that knows whether scans are motion-compensated.
#pragma once

#include <memory>
#include <optional>

#include "client/readers/scan_reader.h"

namespace isthmus::readers {

// The scans of another reader, for the decoder to take as they are: those that are motion-
// compensated have times of 0, and no others. `compensated`: what is known of them; absent: those
// with times of 0 are, unless a later one has true times. What they are taken for is among the
// assumptions.
std::unique_ptr<ScanReader> WatchCompensation(std::unique_ptr<ScanReader> reader,
                                              std::optional<bool> compensated);

}  // namespace isthmus::readers
