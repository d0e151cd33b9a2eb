// The status of a server, from and to the API's message.
#pragma once

#include "core/records/server_status.h"
#include "isthmus/v1/admin_service.pb.h"

namespace isthmus::convert {

v1::ServerStatus ToMessage(const ServerStatus& status);
ServerStatus FromMessage(const v1::ServerStatus& message);

}  // namespace isthmus::convert
