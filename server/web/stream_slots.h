// The limit on answers that come as a stream.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <utility>

namespace isthmus::web {

// Thread safe; must outlive its slots.
class StreamSlots {
 public:
  explicit StreamSlots(size_t most) : most_(most) {}

  // A place, given up when it is destroyed.
  class Slot {
   public:
    explicit Slot(StreamSlots* slots) : slots_(slots) {}
    ~Slot() { --slots_->taken_; }
    Slot(const Slot&) = delete;
    Slot& operator=(const Slot&) = delete;

   private:
    StreamSlots* const slots_;
  };

  // Null where all are taken.
  std::unique_ptr<Slot> Take() {
    ++taken_;
    auto slot = std::make_unique<Slot>(this);
    return taken_ <= most_ ? std::move(slot) : nullptr;
  }

 private:
  const size_t most_;
  std::atomic<size_t> taken_ = 0;
};

}  // namespace isthmus::web
