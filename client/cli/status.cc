// isthmus status: what the server has and whether it is still at work.
#include "api/convert/status.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <algorithm>
#include <map>
#include <vector>

#include "api/convert/map.h"
#include "api/convert/session.h"
#include "client/console/command.h"
#include "client/console/console.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/localising_text.h"
#include "client/console/numbers.h"
#include "client/console/say.h"
#include "client/console/server_figures.h"
#include "client/console/tracking_text.h"
#include "client/console/waiting.h"

namespace isthmus::cli {
namespace {

struct StatusOptions {
  ServerOptions server;
  std::string wait;
  double timeout_s = 300;
  bool json = false;
};

int64_t Rejected(const std::vector<Loop>& loops) {
  return std::count_if(loops.begin(), loops.end(),
                       [](const Loop& loop) { return loop.loop.rejected; });
}

// The amount that a robot has stored.
struct Stored {
  uint64_t map_bytes = 0, scan_bytes = 0, quota_bytes = 0;
};

std::map<RobotId, Stored> StoredByRobot(const std::vector<SessionStatus>& sessions) {
  std::map<RobotId, Stored> robots;
  for (const SessionStatus& session : sessions) {
    Stored& stored = robots[session.record.robot];
    stored.map_bytes += session.map_bytes;
    stored.scan_bytes += session.scan_bytes;
    stored.quota_bytes = session.quota_bytes;
  }
  return robots;
}

// The newest session of each robot.
void ReportTracking(const std::vector<SessionStatus>& sessions) {
  std::map<RobotId, const SessionStatus*> newest;
  for (const SessionStatus& session : sessions) {
    if (session.record.segment == 1) newest[session.record.robot] = &session;
  }
  for (const auto& [robot, session] : newest) {
    Say("tracking     %s: %s%s\n", session->record.id.value(), CountsText(session->scans),
        SegmentAndLossText(*session));
  }
}

void ReportStored(const std::vector<SessionStatus>& sessions) {
  for (const auto& [robot, stored] : StoredByRobot(sessions)) {
    const std::string quota =
        stored.quota_bytes > 0 ? absl::StrCat(" of ", HumanBytes(stored.quota_bytes)) : "";
    const uint64_t total = stored.map_bytes + stored.scan_bytes;
    Say("stored       %s: %s%s (%s map, %s raw scans)%s\n", robot.value(), HumanBytes(total), quota,
        HumanBytes(stored.map_bytes), HumanBytes(stored.scan_bytes),
        stored.quota_bytes > 0 && total > stored.quota_bytes ? ": OVER ITS QUOTA" : "");
  }
  for (const SessionStatus& session : sessions) {
    if (session.archive_problem.empty()) continue;
    Say("ARCHIVE      %s: %s\n", session.record.id.value(), session.archive_problem);
  }
}

Json StoredJson(const std::vector<SessionStatus>& sessions) {
  Json out = Json::object();
  for (const auto& [robot, stored] : StoredByRobot(sessions)) {
    out[robot.value()] = {{"map_bytes", stored.map_bytes},
                          {"scan_bytes", stored.scan_bytes},
                          {"quota_bytes", stored.quota_bytes}};
  }
  return out;
}

Json TrackingJson(const std::vector<SessionStatus>& sessions) {
  Json out = Json::object();
  for (const SessionStatus& session : sessions) {
    if (session.record.segment > 1) continue;  // The newest session of each robot comes last.
    out[session.record.robot.value()] = ToJson(convert::ToMessage(session));
  }
  return out;
}

void ReportReplica(const ReplicaState& replica) {
  Say("replica      %.1f s behind the store; only reads the map", replica.behind_s);
  if (!replica.owner.empty()) Say(" of %s", replica.owner);
  Say("\n");
  if (!replica.problem.empty()) Say("REPLICA      %s\n", replica.problem);
}

void Report(const MapInfo& info, const std::vector<Loop>& loops, const std::string& address) {
  Say("server       %s\nrevision     %d\nstate        %s\nrobots       %d\n", address,
      info.revision, info.settled ? "settled" : "at work", info.robots.size());
  for (const Component& component : info.components) {
    const std::string robots =
        absl::StrJoin(component.robots, ", ",
                      [](std::string* out, const RobotId& robot) { out->append(robot.value()); });
    Say("map %-8d %s (%d points, frame of %s)\n", component.component, robots,
        component.point_count, component.reference.value());
  }
  Say("submaps      %d in the map, %d retired since the server started\n", info.submaps,
      info.retired);
  for (const std::string& problem : info.damaged) Say("damaged      %s\n", problem);
  if (!info.storage_problem.empty()) Say("STORAGE      %s\n", info.storage_problem);
  if (info.replica) ReportReplica(*info.replica);
  Say("loops        %d closed, %d of them rejected by hand\n", loops.size(), Rejected(loops));
  Say("composition  %.1f ms the last of %d, %.1f ms the longest\n", info.composition_ms,
      info.compositions, info.composition_max_ms);
  Say("placement    %.1f ms the last of %d\n", info.placement_ms, info.placements);
  Say("estimation   %.0f ms the last of %d\n", info.estimation_ms, info.estimations);
}

void Report(const ServerStatus& status) {
  const ServerLoad& load = status.load;
  Say("version      %s, up %s\n", status.version, UpTimeText(status.uptime_s));
  if (!status.web_address.empty()) {
    Say("web          %s\n", status.web_address);
  }
  if (load.disk.total_bytes > 0) {
    Say("disk         %s used by the map, %s free\n", HumanBytes(load.disk.used_bytes()),
        HumanBytes(load.disk.free_bytes));
  }
  if (load.matching.workers > 0) {
    Say("workers      %d, with %d jobs\n", load.matching.workers, load.matching.jobs);
  }
  if (load.matching.jobs_set_aside > 0) {
    Say("SET ASIDE    %d jobs during which workers or servers died; the server's log names them\n",
        load.matching.jobs_set_aside);
  }
  for (const DegradedService& degraded : status.degraded) {
    Say("DEGRADED     %s: %s\n", degraded.service, degraded.why);
  }
  for (const SessionLoad& session : load.sessions) {
    Say("lag          %s: not acknowledged %s; not durable %s; queue %d\n", session.session.value(),
        ToString(AckLag(session, load.now_ns)), ToString(DurableLag(session, load.now_ns)),
        session.waiting_scans);
  }
  for (const RobotPlace& place : load.localising) {
    Say("robot        %s: %s\n", NameOf(place), LocalisingText(place, load.now_ns));
  }
}

int Run(const StatusOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto info =
      options.wait.empty()
          ? (*client)->GetMapInfo()
          : Wait(**client, options.wait == "merged" ? WaitFor::kMerged : WaitFor::kSettled,
                 options.timeout_s);
  if (absl::IsDeadlineExceeded(info.status())) return Fail(kNoAnswer, info.status());
  if (!info.ok()) return FailServer(info.status());
  const auto loops = (*client)->ListLoops();
  if (!loops.ok()) return FailServer(loops.status());
  const auto sessions = (*client)->ListSessions();
  if (!sessions.ok()) return FailServer(sessions.status());
  const auto status = (*client)->GetStatus();
  // A server that is older than this one says the rest.
  if (!status.ok() && !absl::IsUnimplemented(status.status())) return FailServer(status.status());
  if (options.json) {
    Json out = ToJson(convert::ToMessage(*info));
    if (status.ok()) out["server"] = ToJson(convert::ToMessage(*status));
    out["loops"] = loops->size();
    out["loops_rejected"] = Rejected(*loops);
    out["stored"] = StoredJson(*sessions);
    out["tracking"] = TrackingJson(*sessions);
    Print(out);
  } else {
    Report(*info, *loops, options.server.address);
    if (status.ok()) Report(*status);
    ReportTracking(*sessions);
    ReportStored(*sessions);
  }
  return kOk;
}

}  // namespace

void AddStatus(CLI::App& app, Action& action) {
  auto options = std::make_shared<StatusOptions>();
  CLI::App* command =
      app.add_subcommand("status", "The server's state: maps, submaps, work in progress");
  AddServerOptions(*command, options->server);
  command
      ->add_option("--wait", options->wait,
                   "Wait until the server has no work left (settled), or until all robots are also "
                   "in one map (merged)")
      ->check(CLI::IsMember({"settled", "merged"}));
  command->add_option("--timeout", options->timeout_s, "Longest wait, seconds")
      ->check(NotNegative())
      ->capture_default_str();
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, &action] { action = [options] { return Run(*options); }; });
}

}  // namespace isthmus::cli
