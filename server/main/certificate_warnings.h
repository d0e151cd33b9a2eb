// Warnings of certificates that expire, while there is time to renew them.
#pragma once

#include <absl/time/time.h>

#include <functional>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/tls/key_files.h"

namespace isthmus::server {

// Not thread safe.
class CertificateWarnings {
 public:
  using Say = std::function<void(const std::string&)>;
  // The clock must outlive it.
  CertificateWarnings(const tls::KeyFiles& files, Say warn, Say inform,
                      const Clock& clock = Clock::System());

  // Reads the files and says once a day of each certificate that it cannot be read, does not belong
  // to its key, has expired, or expires within two weeks, or a third of its life where that is
  // less; and that it was renewed.
  void Check();

 private:
  struct File {
    std::string path;
    absl::Time warned_at = absl::InfinitePast();  // InfinitePast: all was well.
  };
  void CheckFile(File& file);

  const tls::KeyFiles keys_;
  std::vector<File> files_;
  const Say warn_, inform_;
  const Clock& clock_;
};

}  // namespace isthmus::server
