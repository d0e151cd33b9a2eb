#include "server/main/certificate_warnings.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "core/tls/certificate.h"

namespace isthmus::server {
namespace {

constexpr absl::Duration kDay = absl::Hours(24);
// Time for somebody to hear of it, find out how, and do it.
constexpr absl::Duration kWarnBefore = absl::Hours(24 * 14);

std::string Date(absl::Time time) {
  return absl::FormatTime("%Y-%m-%d %H:%M UTC", time, absl::UTCTimeZone());
}

// The text about a trouble with the certificate; empty if there is none.
std::string TroubleOf(const std::string& path, const absl::StatusOr<tls::Certificate>& certificate,
                      absl::Time now) {
  if (!certificate.ok()) {
    return absl::StrCat(certificate.status().message(),
                        "; the server continues with the previous one");
  }
  constexpr char kMend[] =
      ": renew it (`isthmus certs renew`); the server reads the new one by itself";
  const absl::Time end = certificate->not_after;
  const absl::Duration early = std::min(kWarnBefore, (end - certificate->not_before) / 3);
  if (now >= end) {
    return absl::StrCat(path, " has expired on ", Date(end), ", clients refuse it", kMend);
  }
  if (now >= end - early) return absl::StrCat(path, " expires on ", Date(end), kMend);
  return "";
}

}  // namespace

CertificateWarnings::CertificateWarnings(const tls::KeyFiles& files, Say warn, Say inform,
                                         const Clock& clock)
    : keys_(files), warn_(std::move(warn)), inform_(std::move(inform)), clock_(clock) {
  for (const std::string& path : {files.certificate, files.client_ca}) {
    if (!path.empty()) files_.push_back({path});
  }
}

void CertificateWarnings::Check() {
  for (File& file : files_) CheckFile(file);
}

void CertificateWarnings::CheckFile(File& file) {
  const absl::Time now = absl::FromUnixNanos(clock_.NowNs());
  absl::StatusOr<tls::Certificate> certificate = tls::ReadCertificate(file.path);
  if (const bool is_own = file.path == keys_.certificate; is_own && certificate.ok()) {
    if (const auto all = tls::ReadKeyFiles(keys_); !all.ok()) certificate = all.status();
  }
  const std::string trouble = TroubleOf(file.path, certificate, now);
  if (!trouble.empty()) {
    if (now < file.warned_at + kDay) return;
    file.warned_at = now;
    warn_(trouble);
  } else if (file.warned_at != absl::InfinitePast()) {
    file.warned_at = absl::InfinitePast();
    inform_(
        absl::StrCat(file.path, " was renewed and is valid until ", Date(certificate->not_after)));
  }
}

}  // namespace isthmus::server
