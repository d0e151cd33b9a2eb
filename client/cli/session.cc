// isthmus session: what became of robots' runs, and what a person does about them.
#include "api/convert/session.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include <string>
#include <vector>

#include "client/cli/session_list.h"
#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/say.h"

namespace isthmus::cli {
namespace {

struct SessionOptions {
  ServerOptions server;
  std::string session;
  bool open = false, yes = false, json = false;
};

// NotFound, with its sessions where a robot was named.
absl::StatusOr<SessionStatus> FindSession(client::Client& client, const std::string& name) {
  auto found = client.GetSession(SessionId(name));
  if (!absl::IsNotFound(found.status())) return found;
  const auto sessions = client.ListSessions();
  if (!sessions.ok()) return sessions.status();
  std::vector<std::string> own;
  for (const SessionStatus& session : *sessions) {
    const bool is_first = session.record.segment <= 1;
    if (is_first && session.record.robot.value() == name) own.push_back(session.record.id.value());
  }
  if (own.empty()) {
    return absl::NotFoundError(
        absl::StrCat(found.status().message(), "; `isthmus session list` shows all sessions"));
  }
  return absl::NotFoundError(
      absl::StrCat(name, " is a robot: name one of its sessions, ", absl::StrJoin(own, ", ")));
}

int RunList(const SessionOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  auto sessions = (*client)->ListSessions();
  if (!sessions.ok()) return FailServer(sessions.status());
  if (options.open) {
    std::erase_if(*sessions, [](const SessionStatus& session) {
      return session.record.state == SessionState::kFinished;
    });
  }
  PrintSessions(*sessions, options.json);
  return kOk;
}

int RunFinish(const SessionOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto before = FindSession(**client, options.session);
  if (!before.ok()) return FailServer(before.status());
  const auto after = (*client)->FinishSession(before->record.id);
  if (!after.ok()) return FailServer(after.status());
  if (options.json) {
    Print(ToJson(convert::ToMessage(*after)));
  } else {
    Say("%s %s finished: %d scans, %d submaps\n", options.session,
        before->record.state == SessionState::kFinished ? "was already" : "is",
        after->last_sequence, after->submap_count);
  }
  return kOk;
}

int RunDelete(const SessionOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto session = FindSession(**client, options.session);
  if (!session.ok()) return FailServer(session.status());
  if (!options.yes) {
    return Fail(kUsage, absl::InvalidArgumentError(absl::StrCat(
                            options.session, " of robot ", session->record.robot.value(), " has ",
                            session->last_sequence, " scans and ", session->submap_count,
                            " submaps, and deleting is final: give --yes to delete them")));
  }
  const absl::Status deleted = (*client)->DeleteSession(session->record.id);
  if (!deleted.ok()) return FailServer(deleted);
  if (options.json) {
    Print({{"deleted", options.session}});
  } else {
    Say("%s is deleted, and its part of the map is gone\n", options.session);
  }
  return kOk;
}

std::shared_ptr<SessionOptions> Add(CLI::App& session, Action& action, const std::string& name,
                                    const std::string& what, int (*run)(const SessionOptions&)) {
  auto options = std::make_shared<SessionOptions>();
  CLI::App* command = session.add_subcommand(name, what);
  AddServerOptions(*command, options->server);
  command->add_flag("--json", options->json, "As JSON");
  command->callback([options, run, &action] { action = [options, run] { return run(*options); }; });
  return options;
}

}  // namespace

void AddSession(CLI::App& app, Action& action) {
  CLI::App* session = app.add_subcommand("session", "List, finish and delete robots' sessions");
  session->require_subcommand(1);
  const auto listed = Add(*session, action, "list", "Every session of every robot", &RunList);
  session->get_subcommand("list")->add_flag("--open", listed->open, "Only open sessions");
  const auto finished = Add(*session, action, "finish",
                            "Finish a session whose program died: no more scans come", &RunFinish);
  session->get_subcommand("finish")->add_option("SESSION", finished->session)->required();
  const auto deleted = Add(*session, action, "delete",
                           "Delete a session and its part of the map, for good", &RunDelete);
  CLI::App* command = session->get_subcommand("delete");
  command->add_option("SESSION", deleted->session)->required();
  command->add_flag("--yes", deleted->yes, "Really");
}

}  // namespace isthmus::cli
