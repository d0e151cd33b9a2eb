// AdminService.BackUp; see api/isthmus/v1/admin_service.proto.
#pragma once

#include <absl/status/status.h>

#include <mutex>

#include "isthmus/v1/admin_service.pb.h"
#include "server/pipeline.h"
#include "server/rpc/backup_source.h"
#include "server/rpc/emit.h"

namespace isthmus::rpc {

// `busy` is held while a backup is under way.
absl::Status BackUp(server::Pipeline& pipeline, const BackupSource& source, std::mutex& busy,
                    const v1::BackUpRequest& request, const Emit<v1::BackUpResponse>& emit);

}  // namespace isthmus::rpc
