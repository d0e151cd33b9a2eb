// The memory that the scans of all streams may take together, given out in the order of asking.
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>

#include "core/concurrency/mutex.h"

namespace isthmus::rpc {

// Thread safe; must outlive its shares.
class ByteBudget {
 public:
  // So many bytes, held or waited for; gives them back when destroyed.
  class Share {
   public:
    ~Share();
    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;
    size_t bytes() const { return bytes_; }
    bool granted() const;

   private:
    friend class ByteBudget;
    Share(ByteBudget& budget, size_t bytes, std::function<void()> wake)
        : budget_(budget), bytes_(bytes), wake_(std::move(wake)) {}

    ByteBudget& budget_;
    const size_t bytes_;
    const std::function<void()> wake_;
    bool granted_ = false;  // Guarded by the budget's mutex.
  };

  explicit ByteBudget(size_t bytes) : limit_(bytes) {}

  // Granted at once where there is room and nobody waits; else `wake` is called when it is, by
  // whoever gave room back. `wake` must not wait, nor touch the budget. More than there is in all
  // is granted when nothing else is out.
  std::unique_ptr<Share> Ask(size_t bytes, std::function<void()> wake);

  size_t used() const;

 private:
  bool Fits(size_t bytes) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Give(Share* share);

  const size_t limit_;
  mutable Mutex mutex_;
  size_t used_ ABSL_GUARDED_BY(mutex_) = 0;
  std::list<Share*> waiting_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace isthmus::rpc
