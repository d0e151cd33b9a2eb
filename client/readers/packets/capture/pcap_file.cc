#include "client/readers/packets/capture/pcap_file.h"

#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <pcap/pcap.h>

#include <cerrno>
#include <utility>

#include "core/io/file_io.h"
#include "core/nanoseconds.h"

namespace isthmus::readers::capture {
namespace {

constexpr int64_t kLastSecond = int64_t{1} << 32;  // Format: 32 bits in most files.

// A pcapng file may claim any time.
int64_t ArrivalOf(const timeval& time) {
  if (time.tv_sec < 0 || time.tv_sec >= kLastSecond) return 0;
  if (time.tv_usec < 0 || time.tv_usec >= kNsPerSecond) return time.tv_sec * kNsPerSecond;
  return time.tv_sec * kNsPerSecond + time.tv_usec;  // Nanoseconds, as Open asks for.
}

}  // namespace

struct PcapFile::Handle {
  pcap_t* pcap = nullptr;
  FILE* stream = nullptr;  // Owned by pcap.
  int link_type = 0;
  ~Handle() {
    if (pcap != nullptr) pcap_close(pcap);
  }
};

PcapFile::PcapFile(std::unique_ptr<Handle> handle, std::string path)
    : handle_(std::move(handle)), path_(std::move(path)) {}
PcapFile::~PcapFile() = default;

absl::StatusOr<std::unique_ptr<PcapFile>> PcapFile::Open(const std::string& path) {
  FILE* stream = std::fopen(path.c_str(), "rb");
  if (stream == nullptr) return io::FileError("open", path, errno);
  return Open(stream, path);
}

absl::StatusOr<std::unique_ptr<PcapFile>> PcapFile::Open(FILE* stream, const std::string& path) {
  char message[PCAP_ERRBUF_SIZE] = {};
  auto handle = std::make_unique<Handle>();
  handle->pcap =
      pcap_fopen_offline_with_tstamp_precision(stream, PCAP_TSTAMP_PRECISION_NANO, message);
  if (handle->pcap == nullptr) {
    std::fclose(stream);
    return absl::InvalidArgumentError(
        absl::StrCat(path, " is no capture that can be read (.pcap, .pcapng): ", message));
  }
  handle->stream = stream;
  handle->link_type = pcap_datalink(handle->pcap);
  if (!IsKnownLink(handle->link_type)) {
    return absl::InvalidArgumentError(absl::StrCat(
        path, " was captured on a link of type ", handle->link_type,
        ", which is not read: capture on Ethernet, Linux's \"any\" interface or the loopback"));
  }
  return std::unique_ptr<PcapFile>(new PcapFile(std::move(handle), path));
}

std::optional<IpPacket> PcapFile::NextPacket() {
  while (damage_.empty()) {
    const int64_t before = ftello(handle_->stream);
    pcap_pkthdr* header = nullptr;
    const u_char* bytes = nullptr;
    const int result = pcap_next_ex(handle_->pcap, &header, &bytes);
    if (result == PCAP_ERROR_BREAK) return std::nullopt;  // The end.
    if (result != 1) {
      // libpcap reads one kind of interface.
      if (absl::StrContains(pcap_geterr(handle_->pcap), "interface")) {
        damage_ = absl::StrCat(
            path_, " is not damaged, but was captured on interfaces of different ",
            "kinds, which are not read together (", pcap_geterr(handle_->pcap), "): ", frames_,
            " packets before were read; capture on one interface, or on \"any\"");
        return std::nullopt;
      }
      fseeko(handle_->stream, 0, SEEK_END);
      const int64_t size = ftello(handle_->stream);
      damage_ =
          absl::StrCat(path_, " is damaged behind ", frames_, " packets: the last ", size - before,
                       " of ", size, " bytes were skipped (", pcap_geterr(handle_->pcap), ")");
      return std::nullopt;
    }
    ++frames_;
    if (header->caplen < header->len) ++cut_;
    arrival_ns_ = ArrivalOf(header->ts);
    const absl::string_view frame(reinterpret_cast<const char*>(bytes), header->caplen);
    std::optional<IpPacket> packet = ParseFrame(handle_->link_type, frame);
    if (packet) return packet;
  }
  return std::nullopt;
}

std::optional<PcapFile::Arrived> PcapFile::Next(bool headers_only) {
  while (std::optional<IpPacket> packet = NextPacket()) {
    if (packet->fragment && !headers_only) {
      packet = joiner_.Add(*packet, arrival_ns_);
      if (!packet) continue;
    }
    const std::optional<Datagram> datagram = ParseUdp(*packet);
    if (!datagram) continue;
    if (!headers_only && datagram->payload.size() < datagram->length) continue;
    return Arrived{*datagram, arrival_ns_};
  }
  return std::nullopt;
}

std::string PcapFile::Damage() const {
  std::string text = damage_;
  if (cut_ > 0) {
    absl::StrAppend(&text, text.empty() ? path_ + " holds" : "; there are", " ", cut_,
                    " packets that the capture cut short (its snapshot length is too small); those "
                    "of the sensor were skipped");
  }
  if (joiner_.lost() > 0) {
    absl::StrAppend(&text, text.empty() ? path_ + " holds" : "; there are", " ", joiner_.lost(),
                    " packets with missing fragments, which were skipped");
  }
  return text;
}

}  // namespace isthmus::readers::capture
