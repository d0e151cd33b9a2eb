// isthmus certs: a small certificate authority for a field trial.
#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <absl/time/time.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "client/certificates/authority.h"
#include "client/console/command.h"
#include "client/console/exit_code.h"
#include "client/console/json.h"
#include "client/console/numbers.h"
#include "client/console/say.h"
#include "core/tls/certificate.h"

namespace isthmus::cli {
namespace {

// Longest validity of a server's certificate that browsers take; a trial is over by then.
constexpr int kLeafDays = 397;        // Format.
constexpr int kAuthorityDays = 3650;  // Format.
// Validity is counted in seconds.
constexpr double kShortestDays = 1.0 / 86'400;  // Format.

struct CertsOptions {
  std::string folder;
  std::vector<std::string> hosts, clients;
  double days = kLeafDays;
  bool json = false;
};

absl::Duration Days(double days) { return absl::Hours(24) * days; }

int FailCerts(const absl::Status& status) {
  return Fail(absl::IsInvalidArgument(status) ? kUsage : kInput, status);
}

absl::Status IssueAll(const CertsOptions& options) {
  if (!options.hosts.empty()) {
    absl::Status status =
        certificates::IssueServer(options.folder, options.hosts, Days(options.days));
    if (!status.ok()) return status;
  }
  for (const std::string& client : options.clients) {
    absl::Status status = certificates::IssueClient(options.folder, client, Days(options.days));
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

struct Found {
  std::string path;
  tls::Certificate certificate;
};

absl::StatusOr<std::vector<Found>> FindAll(const std::string& folder) {
  std::vector<Found> all;
  std::error_code error;
  for (std::filesystem::directory_iterator at(folder, error), end; at != end && !error;
       at.increment(error)) {
    if (at->path().extension() != ".pem") continue;
    auto certificate = tls::ReadCertificate(at->path().string());
    if (!certificate.ok()) return certificate.status();
    all.push_back({at->path().string(), *std::move(certificate)});
  }
  if (all.empty()) {
    return absl::NotFoundError(absl::StrCat(folder, " has no certificates (*.pem)"));
  }
  std::ranges::sort(all, {}, &Found::path);
  return all;
}

int ShowCerts(const CertsOptions& options) {
  const auto all = FindAll(options.folder);
  if (!all.ok()) return FailCerts(all.status());
  Json json = {{"certificates", Json::array()}};
  for (const auto& [path, certificate] : *all) {
    const double days = absl::ToDoubleHours(certificate.not_after - absl::Now()) / 24;
    const std::string until =
        absl::FormatTime("%Y-%m-%d", certificate.not_after, absl::UTCTimeZone());
    if (options.json) {
      json["certificates"].push_back({{"file", path},
                                      {"subject", certificate.subject},
                                      {"issuer", certificate.issuer},
                                      {"names", certificate.names},
                                      {"not_after", until},
                                      {"days_left", days}});
      continue;
    }
    Say("%-32s %-24s until %s", path, certificate.subject, until);
    if (days < 0) Say(", EXPIRED");
    if (days >= 0) Say(", %.*f days", days < 2 ? 2 : 0, days);
    for (const std::string& name : certificate.names) Say(" %s", name);
    Say("\n");
  }
  if (options.json) Print(json);
  return kOk;
}

int InitCerts(const CertsOptions& options) {
  absl::Status status = certificates::MakeAuthority(options.folder, Days(kAuthorityDays));
  if (status.ok()) status = IssueAll(options);
  if (!status.ok()) return FailCerts(status);
  if (const int code = ShowCerts(options); code != kOk || options.json) return code;
  Say("\nserver:  network:\n"
      "           tls_certificate: %1$s/server.pem\n"
      "           tls_key: %1$s/server.key\n"
      "robots:  export ISTHMUS_TLS_CA=ca.pem, with a copy of %1$s/ca.pem\n"
      "%1$s/ca.key signs others: keep it off the robots\n",
      options.folder);
  return kOk;
}

int SignMore(const CertsOptions& options) {
  const absl::Status status = IssueAll(options);
  return status.ok() ? ShowCerts(options) : FailCerts(status);
}

// Signs new keys for the same names as in the folder.
int RenewCerts(CertsOptions options) {
  const auto all = FindAll(options.folder);
  if (!all.ok()) return FailCerts(all.status());
  for (const auto& [path, certificate] : *all) {
    const std::string name = std::filesystem::path(path).stem().string();
    if (certificate.is_authority) continue;
    if (name == certificates::kServerName) {
      options.hosts = certificate.names;
    } else {
      options.clients.push_back(name);
    }
  }
  return SignMore(options);
}

CLI::App* AddCertsCommand(CLI::App& certs, const char* name, const char* what, Action& action,
                          int (*run)(const CertsOptions&),
                          const std::shared_ptr<CertsOptions>& options) {
  CLI::App* command = certs.add_subcommand(name, what);
  command->add_option("folder", options->folder, "Folder of the authority")->required();
  command->add_flag("--json", options->json, "The certificates as JSON");
  command->callback([options, run, &action] { action = [options, run] { return run(*options); }; });
  return command;
}

void AddDays(CLI::App& command, CertsOptions& options) {
  command
      .add_option("--days", options.days,
                  "Days until the certificates expire, 0.5 is twelve hours; the authority's own "
                  "expires after ten years")
      ->check(Between(kShortestDays, double{kAuthorityDays}))
      ->capture_default_str();
}

CLI::Option* AddHosts(CLI::App& command, CertsOptions& options) {
  return command.add_option("--host", options.hosts,
                            "Name or address under which robots reach the server; may be repeated");
}

void AddClients(CLI::App& command, CertsOptions& options) {
  command.add_option("--client", options.clients,
                     "A robot or person that gets a certificate; may be repeated");
}

}  // namespace

void AddCerts(CLI::App& app, Action& action) {
  CLI::App* certs = app.add_subcommand("certs", "Certificates for a field trial, for TLS");
  certs->require_subcommand(1);
  auto options = std::make_shared<CertsOptions>();
  CLI::App* init = AddCertsCommand(*certs, "init", "Make an authority and the server's certificate",
                                   action, &InitCerts, options);
  AddHosts(*init, *options)->required();
  AddClients(*init, *options);
  AddDays(*init, *options);
  CLI::App* add =
      AddCertsCommand(*certs, "add", "Sign a certificate for another robot, or for other hosts",
                      action, &SignMore, options);
  AddHosts(*add, *options);
  AddClients(*add, *options);
  AddDays(*add, *options);
  CLI::App* renew = AddCertsCommand(
      *certs, "renew",
      "Sign all certificates anew; a running server uses its new one within seconds", action,
      [](const CertsOptions& found) { return RenewCerts(found); }, options);
  AddDays(*renew, *options);
  AddCertsCommand(*certs, "show", "List the certificates with their owners and expiry", action,
                  &ShowCerts, options);
}

}  // namespace isthmus::cli
