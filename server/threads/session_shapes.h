// The shapes by which sessions are matched: of those with loops, as these have straightened them.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/map/submap.h"
#include "server/map/map_view.h"
#include "server/matching/prepared/shape_keeper.h"

namespace isthmus::server {

// Not thread safe. A session without loops is as odometry has it and costs nothing.
class SessionShapes {
 public:
  // The reader gives outlines, or null.
  explicit SessionShapes(SubmapReader outlines) : outlines_(std::move(outlines)) {}

  // The sessions whose shape has to be updated for this view. Of a session that had loops when the
  // server started it is made when a match asks for it.
  std::set<SessionId> FindOutdated(const MapView& view);
  void Update(const MapView& view, const SessionId& session);
  // Leaves the session as its odometry has it, for good.
  void LeaveOut(const SessionId& session);

  // By session, of those that have had loops: grows when submaps of the session that were there
  // before have moved.
  std::map<SessionId, uint32_t> versions() const;

  struct Shaped {
    matching::SubmapList submaps;                         // Outlines, as they are to be matched.
    std::shared_ptr<const matching::SessionShape> shape;  // Null without loops.
  };
  Shaped Of(const MapView& view, const SessionView& session);

 private:
  // All that a shape rests on.
  struct Ground {
    std::vector<std::pair<uint64_t, bool>> loops;  // By id; true: rejected by a person.
    size_t submaps = 0;
    uint32_t next_index = 0;
    bool finished = false;

    friend bool operator==(const Ground&, const Ground&) = default;
  };
  struct State {
    Ground ground;
    uint32_t version = 0;
    bool had_loops = false;  // When the server started: it may have been matched by its shape.
    bool is_made = false, left_out = false;
    matching::ShapeKeeper keeper;
  };
  matching::SubmapList Outlines(const SessionView& session);
  static void SetSizes(const SessionView& session, Ground* ground);

  const SubmapReader outlines_;
  std::optional<uint64_t> seen_;  // The serial of the view looked at last.
  std::map<SessionId, State> states_;
};

}  // namespace isthmus::server
