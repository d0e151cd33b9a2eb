// Opening, listing and ending sessions. One function per RPC; what each returns and fails with is
// said in api/isthmus/v1/session_service.proto.
#pragma once

#include <absl/status/statusor.h>

#include "isthmus/v1/session_service.pb.h"
#include "server/pipeline.h"

namespace isthmus::rpc {

absl::StatusOr<v1::Session> CreateSession(server::Pipeline& pipeline,
                                          const v1::CreateSessionRequest& request);
absl::StatusOr<v1::Session> GetSession(server::Pipeline& pipeline,
                                       const v1::GetSessionRequest& request);
absl::StatusOr<v1::ListSessionsResponse> ListSessions(server::Pipeline& pipeline,
                                                      const v1::ListSessionsRequest& request);
absl::StatusOr<v1::Session> FinishSession(server::Pipeline& pipeline,
                                          const v1::FinishSessionRequest& request);
absl::StatusOr<v1::DeleteSessionResponse> DeleteSession(server::Pipeline& pipeline,
                                                        const v1::DeleteSessionRequest& request);

}  // namespace isthmus::rpc
