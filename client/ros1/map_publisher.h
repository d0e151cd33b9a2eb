// The merged map and the match graph, published as they change.
#pragma once

#include <absl/status/status.h>
#include <ros/node_handle.h>

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "client/library/client.h"
#include "client/ros1/parameters.h"
#include "core/concurrency/mutex.h"

namespace isthmus::ros1 {

// Publishes `map` and `match_graph`, both latched, from a thread of its own that asks the server
// every period_s. The map is sent again only when its revision has changed. A server out of reach
// is asked again; what was published stays.
class MapPublisher {
 public:
  // Called from its thread.
  struct Robot {
    std::function<SessionId()> home;  // In whose component to look; null: the largest.
    // Told the sessions of that component.
    std::function<void(std::set<SessionId>)> on_joined;
  };
  MapPublisher(ros::NodeHandle& node, const Parameters& parameters, Robot robot);
  ~MapPublisher();  // Waits for the call to the server that is under way.

 private:
  void Run();
  bool WaitForNext();
  bool is_ending() const;
  absl::Status Look();
  absl::Status PublishGraph(uint32_t component, int64_t revision);
  absl::Status PublishMap(uint32_t component);

  const Parameters parameters_;
  const Robot robot_;
  const ros::Publisher map_, graph_;
  std::unique_ptr<client::Client> client_;
  // Fields of the thread:
  using Version = std::pair<uint32_t, int64_t>;  // Component, revision.
  std::optional<Version> map_version_, submaps_version_;
  std::vector<SubmapStatus> submaps_;

  mutable Mutex mutex_;
  CondVar changed_;
  bool ending_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;  // Last: it uses all else.
};

}  // namespace isthmus::ros1
