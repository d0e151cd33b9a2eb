#include "server/rpc/streams/byte_budget.h"

#include <utility>

namespace isthmus::rpc {

ByteBudget::Share::~Share() { budget_.Give(this); }

bool ByteBudget::Share::granted() const {
  MutexLock lock(&budget_.mutex_);
  return granted_;
}

bool ByteBudget::Fits(size_t bytes) const { return used_ == 0 || used_ + bytes <= limit_; }

std::unique_ptr<ByteBudget::Share> ByteBudget::Ask(size_t bytes, std::function<void()> wake) {
  std::unique_ptr<Share> share(new Share(*this, bytes, std::move(wake)));
  MutexLock lock(&mutex_);
  if (waiting_.empty() && Fits(bytes)) {
    used_ += bytes;
    share->granted_ = true;
  } else {
    waiting_.push_back(share.get());
  }
  return share;
}

size_t ByteBudget::used() const {
  MutexLock lock(&mutex_);
  return used_;
}

void ByteBudget::Give(Share* share) {
  MutexLock lock(&mutex_);
  if (share->granted_) {
    used_ -= share->bytes_;
  } else {
    waiting_.remove(share);
  }
  while (!waiting_.empty() && Fits(waiting_.front()->bytes_)) {
    Share* next = waiting_.front();
    waiting_.pop_front();
    used_ += next->bytes_;
    next->granted_ = true;
    next->wake_();
  }
}

}  // namespace isthmus::rpc
