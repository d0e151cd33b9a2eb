// Matches, loop closures, anchors and revisions, from and to the API's messages.
#pragma once

#include <absl/status/statusor.h>

#include "core/records/backup_contents.h"
#include "core/records/map_edits.h"
#include "core/records/map_graph.h"
#include "isthmus/v1/admin_service.pb.h"
#include "isthmus/v1/edit_service.pb.h"
#include "isthmus/v1/map_service.pb.h"

namespace isthmus::convert {

v1::SubmapEdge ToMessage(const SubmapEdge& edge);
SubmapEdge FromMessage(const v1::SubmapEdge& edge);

v1::Match ToMessage(const MatchEdge& edge);  // Without its submap edges.
MatchEdge FromMessage(const v1::Match& match);

v1::Placement ToMessage(const PlacedSession& placed);
PlacedSession FromMessage(const v1::Placement& placement);

v1::DecideMatchRequest ToMessage(const MatchDecision& decision);
// InvalidArgument when no decision is named, or SET without a transform.
absl::StatusOr<MatchDecision> FromMessage(const v1::DecideMatchRequest& request);

v1::Loop ToMessage(const Loop& loop);  // Without its submap edges.
Loop FromMessage(const v1::Loop& loop);

v1::DecideLoopRequest ToMessage(const LoopDecision& decision);
// InvalidArgument when no decision is named.
absl::StatusOr<LoopDecision> FromMessage(const v1::DecideLoopRequest& request);

v1::Anchor ToMessage(const RobotAnchor& anchor);
RobotAnchor FromMessage(const v1::Anchor& anchor);
// InvalidArgument without a place, and for numbers that are not finite or a negative sigma.
absl::StatusOr<Anchor> Checked(const v1::Anchor& anchor);

v1::Revision ToMessage(const RevisionInfo& info);
RevisionInfo FromMessage(const v1::Revision& revision);

v1::SubmapMove ToMessage(const SubmapMove& move);
SubmapMove FromMessage(const v1::SubmapMove& move);

v1::BackupContents ToMessage(const BackupContents& contents);
BackupContents FromMessage(const v1::BackupContents& contents);

}  // namespace isthmus::convert
