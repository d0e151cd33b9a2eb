// A file as a stream of responses.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/io/crc32c.h"
#include "server/rpc/emit.h"

namespace isthmus::rpc {

inline constexpr size_t kExportChunkBytes = 1 << 20;

// Cuts a file into responses of at most kExportChunkBytes of data and sums it up in the last one.
// Every response names the revision. `Response` has data, revision, last, size and crc32c. Not
// thread safe.
template <typename Response>
class FileEmitter {
 public:
  FileEmitter(int64_t revision, const Emit<Response>& emit) : emit_(emit) {
    response_.set_revision(revision);
  }

  // False once the reader has gone away; so is Finish.
  bool Add(const std::string& piece) {
    size_ += piece.size();
    crc32c_ = io::Crc32c(piece.data(), piece.size(), crc32c_);
    for (size_t offset = 0; offset < piece.size(); offset += kExportChunkBytes) {
      response_.set_data(piece.data() + offset, std::min(kExportChunkBytes, piece.size() - offset));
      if (!emit_(response_)) return false;
    }
    return true;
  }

  bool Finish() {
    response_.clear_data();
    response_.set_last(true);
    response_.set_size(size_);
    response_.set_crc32c(crc32c_);
    return emit_(response_);
  }

 private:
  const Emit<Response>& emit_;
  Response response_;
  uint64_t size_ = 0;
  uint32_t crc32c_ = 0;
};

}  // namespace isthmus::rpc
