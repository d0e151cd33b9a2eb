// Progress of a file that is being fetched, and its summary once it is there.
#pragma once

#include <cstdint>

#include "core/records/backup_contents.h"

namespace isthmus::client {

struct ExportSummary {
  int64_t revision = 0;
  uint64_t size = 0;    // Bytes.
  uint32_t crc32c = 0;  // Over all bytes.
};

// A backup under way.
struct BackupState {
  double copied = 0;                    // Share of the copy that the server makes first, [0, 1].
  uint64_t bytes = 0, total_bytes = 0;  // Received; of the whole, once the copy is made.
};

struct Backup {
  ExportSummary file;
  BackupContents contents;
  bool has_tokens = false;
};

}  // namespace isthmus::client
