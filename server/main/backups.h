// Backups of the map folder for the network skin to hand out.
#pragma once

#include <string>

#include "server/rpc/backup_source.h"

namespace isthmus::server {

// A source of backups of the folder that this process has open.
rpc::BackupSource BackupsOf(const std::string& folder);

}  // namespace isthmus::server
