// Symmetric 6x6 matrices as 21 little-endian float64: the upper triangle, row by row.
#pragma once

#include <string>

#include "core/byte_stream.h"
#include "core/pose.h"

namespace isthmus::storage {

inline constexpr size_t kSymmetricSize = 21 * 8;

inline void AppendSymmetric(const Matrix6d& matrix, std::string& out) {
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) AppendBytes(matrix(row, column), out);
  }
}

// Zeros from where the reader runs out of bytes.
inline Matrix6d ReadSymmetric(ByteReader& reader) {
  Matrix6d matrix;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      matrix(row, column) = matrix(column, row) = reader.Read<double>();
    }
  }
  return matrix;
}

}  // namespace isthmus::storage
