// The limit on answers that come as a stream.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "core/concurrency/mutex.h"

namespace isthmus::web {

// Thread safe; must outlive its slots.
class StreamSlots {
 public:
  // At most so many, and so many of one address.
  StreamSlots(size_t most, size_t most_of_one) : most_(most), most_of_one_(most_of_one) {}

  // A place, given up when it is destroyed.
  class Slot {
   public:
    Slot(StreamSlots* slots, std::string address) : slots_(slots), address_(std::move(address)) {}
    ~Slot() { slots_->GiveUp(address_); }
    Slot(const Slot&) = delete;
    Slot& operator=(const Slot&) = delete;

   private:
    StreamSlots* const slots_;
    const std::string address_;
  };

  // Null where all are taken, or all that the address of the peer (http::Request::peer) may have.
  std::unique_ptr<Slot> Take(const std::string& peer) {
    std::string address = peer.substr(0, peer.rfind(':'));
    {
      MutexLock lock(&mutex_);
      const auto known = of_each_.find(address);
      if (taken_ >= most_ || (known != of_each_.end() && known->second >= most_of_one_)) {
        return nullptr;
      }
      ++taken_;
      ++of_each_[address];
    }
    return std::make_unique<Slot>(this, std::move(address));
  }

 private:
  void GiveUp(const std::string& address) {
    MutexLock lock(&mutex_);
    --taken_;
    if (const auto it = of_each_.find(address); --it->second == 0) of_each_.erase(it);
  }

  const size_t most_, most_of_one_;
  Mutex mutex_;
  size_t taken_ ABSL_GUARDED_BY(mutex_) = 0;
  std::map<std::string, size_t> of_each_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::web
