#include "client/library/stream/outage.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

namespace isthmus::client {

std::string Outage::Failed(const absl::Status& why, double now_s) {
  if (failures_++ == 0) since_s_ = now_s;
  if (!told_.insert(why.code()).second) return {};
  return absl::StrCat("interrupted, trying again: ", why.message());
}

std::string Outage::Ended(double now_s) {
  if (failures_ == 0) return {};
  std::string news =
      absl::StrFormat("goes on after %.1f s, attempt %d", now_s - since_s_, failures_);
  *this = Outage();
  return news;
}

}  // namespace isthmus::client
