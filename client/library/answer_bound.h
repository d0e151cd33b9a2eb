// The most that one answer of a server may bring. Private to the library.
#pragma once

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <cstdint>

namespace isthmus::client {

// Counts what comes. Not thread safe.
class AnswerBound {
 public:
  explicit AnswerBound(uint64_t most_bytes) : most_(most_bytes) {}

  // ResourceExhausted once it is more than the bound; the rest is not to be read.
  absl::Status Add(uint64_t bytes) {
    sum_ += bytes;
    if (sum_ <= most_) return absl::OkStatus();
    return absl::ResourceExhaustedError(absl::StrCat(
        "the answer has more than the ", most_,
        " bytes that this client takes: ask for less at a time, such as one component, "
        "one robot or a box, or raise its bound (ClientOptions); if so much cannot be, "
        "this is no sound server"));
  }
  void Restart() { sum_ = 0; }

 private:
  const uint64_t most_;
  uint64_t sum_ = 0;
};

}  // namespace isthmus::client
