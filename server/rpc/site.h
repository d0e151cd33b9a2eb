// One map of the server, with what the network skin keeps beside its pipeline.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <utility>

#include "server/pipeline.h"
#include "server/rpc/backup_source.h"
#include "server/rpc/scans/scan_streams.h"
#include "server/rpc/upload_staging.h"

namespace isthmus::rpc {

// Thread safe. The pipeline must outlive it.
struct Site {
  // `scan_window` as ScanStreams, `uploads_folder` and `max_staged_bytes` as UploadStaging have
  // them. A null source: there are no backups.
  Site(std::string site_name, server::Pipeline* site_pipeline, BackupSource source,
       const AckWindow::Limits& scan_window, const std::string& uploads_folder,
       uint64_t max_staged_bytes)
      : name(std::move(site_name)),
        pipeline(*site_pipeline),
        backup(std::move(source)),
        streams(pipeline.sessions(), scan_window),
        staging(uploads_folder, max_staged_bytes) {}

  const std::string name;
  server::Pipeline& pipeline;
  const BackupSource backup;
  std::atomic<bool> backing_up = false;
  ScanStreams streams;
  UploadStaging staging;
};

}  // namespace isthmus::rpc
