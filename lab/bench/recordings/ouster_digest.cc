#include "lab/bench/recordings/ouster_digest.h"

#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>
#include <openssl/evp.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "client/readers/packets/capture/pcap_file.h"
#include "client/readers/packets/ouster/ouster_metadata.h"
#include "client/readers/packets/ouster/ouster_packet.h"
#include "core/io/file_io.h"

namespace isthmus::bench {
namespace {

using readers::capture::PcapFile;
using readers::ouster::Metadata;
using readers::ouster::PacketLayout;
using readers::ouster::Pixel;

// The images of a frame; what was not measured is 0.
struct Images {
  std::vector<uint32_t> range;
  std::vector<uint8_t> reflectivity;
  std::vector<uint16_t> signal, near_ir, measurement;
  std::vector<uint64_t> timestamp;
};

template <typename T>
std::string Md5(const std::vector<T>& values) {
  unsigned char hash[EVP_MAX_MD_SIZE];
  unsigned int size = 0;
  EVP_Digest(values.data(), values.size() * sizeof(T), hash, &size, EVP_md5(), nullptr);
  return absl::BytesToHexString(absl::string_view(reinterpret_cast<const char*>(hash), size));
}

void AddColumn(const PacketLayout& layout, absl::string_view packet, int column, size_t width,
               Images& images) {
  const PacketLayout::Column header = layout.ColumnAt(packet, column);
  images.timestamp[header.measurement] = header.timestamp_ns;
  images.measurement[header.measurement] = header.measurement;
  for (int row = 0; row < layout.rows(); ++row) {
    const Pixel pixel = layout.PixelAt(packet, column, row, 0);
    const size_t at = static_cast<size_t>(row) * width + header.measurement;
    images.range[at] = pixel.range_mm;
    images.reflectivity[at] = static_cast<uint8_t>(pixel.reflectivity);
    images.signal[at] = pixel.signal;
    images.near_ir[at] = pixel.near_ir;
  }
}

Images ReadFrame(const Metadata& metadata, int frame, PcapFile& file) {
  const PacketLayout layout(metadata);
  const size_t width = static_cast<size_t>(metadata.columns_per_frame);
  const size_t pixels = width * static_cast<size_t>(metadata.pixels_per_column);
  Images images;
  images.range.resize(pixels);
  images.reflectivity.resize(pixels);
  images.signal.resize(pixels);
  images.near_ir.resize(pixels);
  images.timestamp.resize(width);
  images.measurement.resize(width);
  while (const std::optional<PcapFile::Arrived> arrived = file.Next()) {
    const absl::string_view packet = arrived->datagram.payload;
    if (!layout.Fits(packet)) continue;
    for (int column = 0; column < layout.columns(); ++column) {
      const PacketLayout::Column header = layout.ColumnAt(packet, column);
      if (!header.valid || header.frame != frame || header.measurement >= width) continue;
      AddColumn(layout, packet, column, width, images);
    }
  }
  return images;
}

}  // namespace

absl::StatusOr<std::vector<DigestLine>> CompareDigest(const std::string& capture,
                                                      const std::string& metadata,
                                                      const std::string& digest) {
  const absl::StatusOr<std::string> metadata_text = io::ReadFile(metadata);
  if (!metadata_text.ok()) return metadata_text.status();
  const absl::StatusOr<std::string> digest_text = io::ReadFile(digest);
  if (!digest_text.ok()) return digest_text.status();
  const absl::StatusOr<Metadata> parsed = readers::ouster::ParseMetadata(*metadata_text);
  if (!parsed.ok()) return parsed.status();
  const auto json = nlohmann::json::parse(*digest_text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains("scans") || !json["scans"].is_array() ||
      json["scans"].empty()) {
    return absl::InvalidArgumentError(absl::StrCat(digest, " holds no hashes of scans"));
  }
  absl::StatusOr<std::unique_ptr<PcapFile>> file = PcapFile::Open(capture);
  if (!file.ok()) return file.status();
  const auto& scan = json["scans"][0];
  const int frame = std::atoi(scan.value("FRAME_ID", "0").c_str());
  const Images images = ReadFrame(*parsed, frame, **file);
  std::vector<DigestLine> lines;
  for (const auto& [field, ours] :
       {std::pair("RANGE", Md5(images.range)), std::pair("REFLECTIVITY", Md5(images.reflectivity)),
        std::pair("SIGNAL", Md5(images.signal)), std::pair("NEAR_IR", Md5(images.near_ir)),
        std::pair("TIMESTAMP", Md5(images.timestamp)),
        std::pair("MEASUREMENT_ID", Md5(images.measurement))}) {
    if (scan.contains(field)) lines.push_back({field, scan.value(field, ""), ours});
  }
  return lines;
}

}  // namespace isthmus::bench
