// AdminService.BackUp; see api/isthmus/v1/admin_service.proto.
#pragma once

#include <absl/status/status.h>

#include <atomic>

#include "isthmus/v1/admin_service.pb.h"
#include "server/pipeline.h"
#include "server/rpc/backup_source.h"
#include "server/rpc/emit.h"

namespace isthmus::rpc {

// `busy` is true while a backup is under way.
absl::Status BackUp(server::Pipeline& pipeline, const BackupSource& source, std::atomic<bool>& busy,
                    const v1::BackUpRequest& request, const Emit<v1::BackUpResponse>& emit);

}  // namespace isthmus::rpc
