// Warnings of certificates that expire, while there is time to renew them.
#pragma once

#include <absl/time/time.h>

#include <functional>
#include <string>
#include <vector>

#include "core/clock.h"

namespace isthmus::server {

// Not thread safe.
class CertificateWarnings {
 public:
  using Say = std::function<void(const std::string&)>;
  // Files in PEM format. The clock must outlive it.
  CertificateWarnings(std::vector<std::string> paths, Say warn, Say inform,
                      const Clock& clock = Clock::System());

  // Reads the files and says once a day of each that it cannot be read, has expired, or expires
  // within two weeks, or a third of its life where that is less; and that it was renewed.
  void Check();

 private:
  struct File {
    std::string path;
    absl::Time warned_at = absl::InfinitePast();  // InfinitePast: all was well.
  };
  void CheckFile(File& file);

  std::vector<File> files_;
  const Say warn_, inform_;
  const Clock& clock_;
};

}  // namespace isthmus::server
