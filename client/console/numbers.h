// Checks of the numbers that an option takes: CLI11's own print bounds of 309 digits.
#pragma once

#include <CLI/App.hpp>

namespace isthmus::cli {

// Any, above 0, from 0 on, and from one to another; finite, and where it is a whole number one that
// fits 64 bits.
CLI::Validator Finite();
CLI::Validator Positive();
CLI::Validator NotNegative();
CLI::Validator Between(double least, double most);  // CLI::Range takes what is not a number, too.

}  // namespace isthmus::cli
