#include "lab/loadgen/link_profile.h"

#include <absl/strings/str_cat.h>

namespace isthmus::loadgen {

bool LinkProfile::is_perfect() const {
  return delay_s == 0 && jitter_s == 0 && up_bytes_s == 0 && down_bytes_s == 0 &&
         stall_every_s == 0 && reset_every_s == 0;
}

// A hall's Wi-Fi and a public 4G network as a moving machine gets them, in round figures: roaming
// between access points takes about half a second, a handover of 4G one to two.
absl::StatusOr<LinkProfile> FindLinkProfile(const std::string& name) {
  if (name == "none") return LinkProfile();
  if (name == "wifi") {
    return LinkProfile{.delay_s = 0.003,
                       .jitter_s = 0.006,
                       .up_bytes_s = 4e6,
                       .down_bytes_s = 4e6,
                       .stall_every_s = 30,
                       .stall_s = 0.5,
                       .reset_every_s = 600};
  }
  if (name == "4g") {
    return LinkProfile{.delay_s = 0.03,
                       .jitter_s = 0.03,
                       .up_bytes_s = 1.5e6,
                       .down_bytes_s = 4e6,
                       .stall_every_s = 60,
                       .stall_s = 1.5,
                       .reset_every_s = 180};
  }
  return absl::InvalidArgumentError(
      absl::StrCat("there is no link \"", name, "\": none, wifi or 4g"));
}

}  // namespace isthmus::loadgen
