// isthmus datum: where on the Earth the site's frame lies.

#include <optional>

#include "api/convert/map.h"
#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/say.h"

namespace isthmus::cli {
namespace {

struct DatumOptions {
  ServerOptions server;
  Datum datum;
  bool json = false;
};

// As the server has it now.
int ShowDatum(client::Client& client, bool json) {
  const auto info = client.GetMapInfo();
  if (!info.ok()) return FailServer(info.status());
  if (json) {
    const std::optional<Datum>& datum = info->datum;
    Print({{"datum", datum ? ToJson(convert::ToMessage(*datum)) : Json(nullptr)}});
  } else if (!info->datum) {
    Say("no datum: the map's place on the Earth is unknown\n");
  } else {
    Say("latitude %.9f, longitude %.9f, altitude %.3f m, heading %.3f deg\n",
        info->datum->latitude_deg, info->datum->longitude_deg, info->datum->altitude_m,
        info->datum->heading_deg);
  }
  return kOk;
}

int PutDatum(const DatumOptions& options, const std::optional<Datum>& datum) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  if (absl::Status status = (*client)->SetDatum(datum); !status.ok()) return FailServer(status);
  return ShowDatum(**client, options.json);
}

int RunDatumSet(const DatumOptions& options) { return PutDatum(options, options.datum); }
int RunDatumClear(const DatumOptions& options) { return PutDatum(options, std::nullopt); }

int RunDatumShow(const DatumOptions& options) {
  const auto client = Connect(options.server);
  if (!client.ok()) return FailServer(client.status());
  return ShowDatum(**client, options.json);
}

CLI::App* AddDatumCommand(CLI::App& datum, const char* name, const char* what, Action& action,
                          const std::shared_ptr<DatumOptions>& options,
                          int (*run)(const DatumOptions&)) {
  CLI::App* command = datum.add_subcommand(name, what);
  AddServerOptions(*command, options->server);
  command->add_flag("--json", options->json, "The datum as JSON");
  command->callback([options, run, &action] { action = [options, run] { return run(*options); }; });
  return command;
}

}  // namespace

void AddDatum(CLI::App& app, Action& action) {
  CLI::App* datum =
      app.add_subcommand("datum", "The datum: the place of the anchors' frame on the Earth");
  datum->require_subcommand(1);
  auto options = std::make_shared<DatumOptions>();
  CLI::App* set = AddDatumCommand(*datum, "set", "Set the place of the origin (WGS 84)", action,
                                  options, &RunDatumSet);
  set->add_option("--lat", options->datum.latitude_deg, "Latitude, degrees north")->required();
  set->add_option("--lon", options->datum.longitude_deg, "Longitude, degrees east")->required();
  set->add_option("--alt", options->datum.altitude_m, "Metres above the ellipsoid")->required();
  set->add_option("--heading", options->datum.heading_deg,
                  "Direction of the frame's y axis, degrees clockwise from north; 0: x is east")
      ->capture_default_str();
  AddDatumCommand(*datum, "show", "Show the datum", action, std::make_shared<DatumOptions>(),
                  &RunDatumShow);
  AddDatumCommand(*datum, "clear", "Remove the datum", action, std::make_shared<DatumOptions>(),
                  &RunDatumClear);
}

}  // namespace isthmus::cli
