// Judged limits of access.
#pragma once

#include <cstddef>
#include <cstdint>

namespace isthmus::access {

// Random bytes of a secret: 256 bits. Below 192 a search over all of them would begin to be
// thinkable, and their plain SHA-256 would no longer do at rest.
inline constexpr size_t kSecretBytes = 32;

// Tokens in one file. Each call compares its secret with all of them, 10 ns each; more would cost a
// call more than it does.
inline constexpr size_t kMaxTokens = 4096;

// Characters of a token's name, a robot's or a site's, as of a robot's name in the API.
inline constexpr size_t kMaxName = 64;

// Robots, or sites, of one token. A fleet has a pattern; more would make lines of the file, and of
// answers, that nobody reads.
inline constexpr size_t kMaxPatterns = 100;

// Time for which the file is believed before it is looked at again. A revoked token holds so much
// longer; a shorter time costs a system call for more calls.
inline constexpr int64_t kLookAgainNs = 1'000'000'000;

}  // namespace isthmus::access
