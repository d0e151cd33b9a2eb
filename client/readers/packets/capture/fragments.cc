#include "client/readers/packets/capture/fragments.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "client/readers/packets/limits.h"

namespace isthmus::readers::capture {

std::list<FragmentJoiner::Open>::iterator FragmentJoiner::Find(const IpPacket& fragment,
                                                               int64_t arrival_ns) {
  for (auto it = open_.begin(); it != open_.end(); ++it) {
    const IpPacket& packet = it->packet;
    if (packet.id != fragment.id || packet.protocol != fragment.protocol ||
        packet.source != fragment.source || packet.destination != fragment.destination) {
      continue;
    }
    const int64_t age_ns = arrival_ns - it->arrival_ns;
    if (age_ns >= 0 && age_ns <= kFragmentAgeNs) return it;
    open_.erase(it);
    ++lost_;
    break;
  }
  if (open_.size() >= kMaxOpenDatagrams) {
    open_.pop_front();
    ++lost_;
  }
  Open& open = open_.emplace_back();
  open.packet = fragment;
  open.packet.payload = {};
  open.arrival_ns = arrival_ns;
  return std::prev(open_.end());
}

std::optional<IpPacket> FragmentJoiner::Add(const IpPacket& fragment, int64_t arrival_ns) {
  const size_t size = fragment.payload.size();
  const size_t end = fragment.offset + size;
  // All but the last are multiples of 8 bytes.
  if (size == 0 || size != fragment.length || end >= kMaxBytes ||
      (fragment.more && size % 8 != 0)) {
    return std::nullopt;
  }
  const auto open = Find(fragment, arrival_ns);
  if (!fragment.more) open->size = end;
  if (open->bytes.size() < end) open->bytes.resize(end);
  std::memcpy(open->bytes.data() + fragment.offset, fragment.payload.data(), size);
  for (size_t piece = fragment.offset / 8; piece < (end + 7) / 8; ++piece) {
    if (open->here[piece]) continue;
    open->here.set(piece);
    ++open->pieces;
  }
  if (!open->size || open->pieces < (*open->size + 7) / 8) return std::nullopt;
  done_ = std::move(*open);
  open_.erase(open);
  IpPacket whole = done_.packet;
  whole.payload = absl::string_view(done_.bytes).substr(0, *done_.size);
  whole.length = whole.payload.size();
  whole.fragment = whole.more = false;
  whole.offset = 0;
  return whole;
}

}  // namespace isthmus::readers::capture
