#include "client/readers/recording.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "client/readers/compensated_reader.h"
#include "client/readers/distinct_reader.h"
#include "client/readers/range_reader.h"

namespace isthmus::readers {

absl::StatusOr<std::unique_ptr<ScanReader>> Recording::OpenScans(size_t topic,
                                                                 const ReadOptions& options) const {
  if (topic >= scan_topics().size()) {
    return absl::InvalidArgumentError(absl::StrCat("there is no topic ", topic));
  }
  if (options.to && *options.to < options.from) {
    return absl::InvalidArgumentError(
        absl::StrCat("no scans from ", options.from, " to ", *options.to));
  }
  ReadOptions read = options;
  if (!read.compensated && are_compensated()) read.compensated = true;
  if (read.compensated == true) read.stamps = StampMeaning::kEnd;
  absl::StatusOr<std::unique_ptr<ScanReader>> all = OpenAllScans(topic, read);
  if (!all.ok()) return all;
  all = WatchCompensation(*std::move(all), read.compensated);
  const std::optional<uint64_t> size = (*all)->size();
  if (size && options.from >= *size) {
    return absl::InvalidArgumentError(
        absl::StrCat("no scans from ", options.from, " on: the recording holds ", *size));
  }
  return LeaveOutTwins(TakeRange(*std::move(all), options.from, options.to));
}

absl::StatusOr<std::vector<GnssFix>> Recording::ReadFixes(size_t) const {
  return std::vector<GnssFix>();
}

absl::StatusOr<std::vector<StaticTransform>> Recording::ReadStaticTransforms() const {
  return std::vector<StaticTransform>();
}

}  // namespace isthmus::readers
