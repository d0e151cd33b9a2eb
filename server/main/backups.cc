#include "server/main/backups.h"

#include "storage/upkeep/backup_stream.h"

namespace isthmus::server {

rpc::BackupSource BackupsOf(const std::string& folder) {
  return [folder](const rpc::BackupSink& sink) -> absl::StatusOr<BackupContents> {
    const absl::StatusOr<storage::StoreReport> report =
        storage::StreamBackup(folder, {sink.progress, sink.begin, sink.piece});
    if (!report.ok()) return report.status();
    return BackupContents{report->sessions, report->submaps,       report->scans,
                          report->points,   report->damaged_count, ToString(*report)};
  };
}

}  // namespace isthmus::server
