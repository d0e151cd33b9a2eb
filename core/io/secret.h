// Secrets: bytes that nobody can guess, and comparing what must not be guessed byte by byte.
#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstddef>
#include <string>

namespace isthmus::io {

// From the kernel's source of randomness. Internal where it gives none.
absl::StatusOr<std::string> RandomBytes(size_t size);

// The time it takes depends on the sizes only, not on the places where the bytes differ.
bool SameSecret(absl::string_view a, absl::string_view b);

}  // namespace isthmus::io
