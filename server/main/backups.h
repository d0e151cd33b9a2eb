// Backups of the map folder for the network skin to hand out.
#pragma once

#include <string>

#include "server/rpc/server.h"

namespace isthmus::server {

// Of the folder that this process has open.
rpc::BackupSource BackupsOf(const std::string& folder);

}  // namespace isthmus::server
