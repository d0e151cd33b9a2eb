// isthmus revisions: how the map changed, and taking a change back.
#include <optional>

#include "api/convert/graph.h"
#include "client/cli/moves_text.h"
#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/numbers.h"
#include "client/console/say.h"

namespace isthmus::cli {
namespace {

struct RevisionsOptions {
  ServerOptions server;
  int limit = 20;
  int64_t from = 0, to = 0, revision = 0;
  std::string note;
  bool json = false;
};

// A revision that is no longer kept is as unknown as one that never was.
int FailRevision(const absl::Status& status) {
  return absl::IsOutOfRange(status) ? Fail(kUnknown, status) : FailServer(status);
}

int RunList(const RevisionsOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto revisions = (*client)->ListRevisions(options.limit);
  if (!revisions.ok()) return FailServer(revisions.status());
  if (options.json) {
    Json out = Json::array();
    for (const RevisionInfo& revision : *revisions) {
      out.push_back(ToJson(convert::ToMessage(revision)));
    }
    Print({{"revisions", std::move(out)}});
    return kOk;
  }
  SayLines(RevisionHeader());
  for (const RevisionInfo& revision : *revisions) SayLines(RevisionLine(revision));
  return kOk;
}

// With "move_m" and "move_deg" of each submap that neither came nor went nor changed its frame.
Json DiffJson(const RevisionDiff& diff) {
  v1::DiffRevisionsResponse response;
  response.set_from_revision(diff.from);
  response.set_to_revision(diff.to);
  for (const RevisionInfo& revision : diff.revisions) {
    *response.add_revisions() = convert::ToMessage(revision);
  }
  for (const SubmapMove& move : diff.moves) *response.add_moves() = convert::ToMessage(move);
  Json out = ToJson(response);
  for (size_t i = 0; i < diff.moves.size(); ++i) {
    const std::optional<MoveSize> size = SizeOf(diff.moves[i]);
    if (size) out["moves"][i].update({{"move_m", size->metres}, {"move_deg", size->degrees}});
  }
  return out;
}

int RunDiff(const RevisionsOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto diff = (*client)->DiffRevisions(options.from, options.to);
  if (!diff.ok()) return FailRevision(diff.status());
  if (options.json) {
    Print(DiffJson(*diff));
    return kOk;
  }
  Say("revision %d to %d: %d submaps came, moved or went\n", diff->from, diff->to,
      diff->moves.size());
  for (const SubmapMove& move : diff->moves) SayLines("  " + MoveLine(move));
  if (!diff->revisions.empty()) SayLines(RevisionHeader());
  for (const RevisionInfo& revision : diff->revisions) SayLines(RevisionLine(revision));
  return kOk;
}

int RunUndo(const RevisionsOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  const auto revision = (*client)->UndoRevision(options.revision, options.note);
  if (!revision.ok()) return FailRevision(revision.status());
  if (options.json) {
    Print({{"undone", options.revision}, {"revision", *revision}});
  } else {
    Say("revision %d is undone: the map is at revision %d\n", options.revision, *revision);
  }
  return kOk;
}

void AddDiff(CLI::App& revisions, Action& action,
             const std::shared_ptr<RevisionsOptions>& options) {
  CLI::App* command =
      revisions.add_subcommand("diff", "Show which submaps moved between two revisions");
  command->fallthrough();
  command->add_option("FROM", options->from, "0: the empty map")->check(NotNegative())->required();
  command->add_option("TO", options->to, "Later revision; without it the newest")
      ->check(Positive());
  command->footer("--server, --attempts and --json as for `isthmus revisions`.");
  command->callback([options, &action] { action = [options] { return RunDiff(*options); }; });
}

void AddUndo(CLI::App& revisions, Action& action,
             const std::shared_ptr<RevisionsOptions>& options) {
  CLI::App* command = revisions.add_subcommand(
      "undo", "Undo a revision: reject the matches and loop closures that caused it");
  command->fallthrough();
  command->add_option("REVISION", options->revision, "Number of the revision")
      ->check(Positive())
      ->required();
  command->add_option("--note", options->note, "Reason; stored with the rejections");
  command->footer("--server, --attempts and --json as for `isthmus revisions`.");
  command->callback([options, &action] { action = [options] { return RunUndo(*options); }; });
}

}  // namespace

void AddRevisions(CLI::App& app, Action& action) {
  auto options = std::make_shared<RevisionsOptions>();
  CLI::App* command =
      app.add_subcommand("revisions", "List the changes of the map, the newest first; undo one");
  AddServerOptions(*command, options->server);
  command->add_option("--limit", options->limit, "At most this many")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command->add_flag("--json", options->json, "As JSON");
  AddDiff(*command, action, options);
  AddUndo(*command, action, options);
  command->callback([options, command, &action] {  // Also after a subcommand's.
    if (command->get_subcommands().empty()) action = [options] { return RunList(*options); };
  });
}

}  // namespace isthmus::cli
