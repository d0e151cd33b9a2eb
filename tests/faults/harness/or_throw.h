// A value, or an exception that ends the campaign.
#pragma once

#include <absl/status/statusor.h>

#include <stdexcept>
#include <utility>

namespace isthmus::faults {

template <typename T>
T OrThrow(absl::StatusOr<T> value) {
  if (!value.ok()) throw std::runtime_error(value.status().ToString());
  return *std::move(value);
}

}  // namespace isthmus::faults
