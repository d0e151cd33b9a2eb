// Bytes of anybody, taken for the files of a folder of scans: PLY, LAS, PCD, .bin without a header
// and rows of numbers. The first byte says for which; see corpus/clouds.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>

#include "client/readers/stamps.h"
#include "core/codec/payload_layout.h"
#include "core/codec/scan_decoder.h"
#include "core/formats/cloud_file.h"
#include "core/formats/kitti_bin.h"
#include "core/formats/pcd.h"

namespace isthmus {
namespace {

// Bytes of a cloud per byte of its file: LZF gives 88 of one, and what is not packed a number of 8
// for a digit and what parts it from the next, or for an empty cell of a table.
constexpr size_t kMostRatio = 88, kMostValueRatio = 4, kMostCellRatio = 8;

void Check(const absl::StatusOr<PointPayload>& payload, size_t file_size, size_t ratio) {
  if (!payload.ok()) return;
  if (payload->data.size() > file_size * ratio) std::abort();
  if (!codec::CheckLayout(*payload).ok()) return;  // As FolderRecording does.
  (void)codec::DecodeScan(*payload, 0, 1'700'000'000'000'000'000);
  readers::ScanStamps stamps(readers::StampMeaning::kByTimes, 10);
  for (int64_t second : {0, 1, 1'700'000'000}) {
    (void)stamps.End(*payload, second * 1'000'000'000, second + 1);
  }
}

void TryPcd(const std::string& bytes) {
  absl::StatusOr<formats::PcdFile> file = formats::ParsePcd(bytes);
  if (file.ok()) Check(std::move(file->payload), bytes.size(), kMostRatio);
}

}  // namespace
}  // namespace isthmus

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace isthmus;
  if (size == 0) return 0;
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0]) {
    case 'y':
      Check(formats::ParsePly(bytes), bytes.size(), kMostValueRatio);
      break;
    case 'l':
      Check(formats::ParseLas(bytes), bytes.size(), kMostValueRatio);
      break;
    case 'c':
      TryPcd(bytes);
      break;
    case 'b':
      Check(formats::ParseKittiBin(bytes), bytes.size(), 1);
      break;
    default:
      // A last number needs nothing behind it.
      Check(formats::ParseText(bytes), bytes.size() + 1, kMostCellRatio);
      break;
  }
  return 0;
}
