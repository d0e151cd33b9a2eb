// Checks of the numbers that an option takes: CLI11's own print bounds of 309 digits.
#pragma once

#include <CLI/App.hpp>

namespace isthmus::cli {

// Above 0, and from 0 on; finite, and where it is a whole number one that fits 64 bits.
CLI::Validator Positive();
CLI::Validator NotNegative();

}  // namespace isthmus::cli
