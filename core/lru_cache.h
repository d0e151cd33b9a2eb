// Values by key, in the order in which they were used, and how much they weigh together.
#pragma once

#include <cstddef>
#include <iterator>
#include <list>
#include <unordered_map>
#include <utility>

namespace isthmus {

// Drops nothing by itself: its owner knows what may go. Not thread safe; who shares one has a lock
// around it.
template <typename Key, typename Value>
class LruCache {
 public:
  struct Entry {
    Key key;
    Value value;
    size_t weight;
  };

  // In place of what was there under the key; the latest used.
  void Put(const Key& key, Value value, size_t weight = 1) {
    Erase(key);
    std::list<Entry> entry;
    entry.push_back({key, std::move(value), weight});
    found_[key] = entry.begin();  // May throw, and then nothing has changed.
    entries_.splice(entries_.end(), entry);
    weight_ += weight;
  }
  // Null where there is none; else the latest used from now on.
  Value* Use(const Key& key) {
    const auto it = found_.find(key);
    if (it == found_.end()) return nullptr;
    entries_.splice(entries_.end(), entries_, it->second);
    return &it->second->value;
  }
  void Erase(const Key& key) {
    const auto it = found_.find(key);
    if (it == found_.end()) return;
    weight_ -= it->second->weight;
    entries_.erase(it->second);
    found_.erase(it);
  }
  // The entries whose key `goes` is true of.
  template <typename Predicate>
  void EraseIf(const Predicate& goes) {
    for (auto it = entries_.begin(); it != entries_.end();) {
      const auto next = std::next(it);
      if (goes(it->key)) Erase(Key(it->key));
      it = next;
    }
  }

  // The one that was used longest ago; there must be one.
  const Entry& oldest() const { return entries_.front(); }
  void DropOldest() { Erase(Key(entries_.front().key)); }

  bool empty() const { return entries_.empty(); }
  size_t size() const { return entries_.size(); }
  size_t weight() const { return weight_; }

 private:
  std::list<Entry> entries_;  // The one used longest ago first.
  std::unordered_map<Key, typename std::list<Entry>::iterator> found_;
  size_t weight_ = 0;
};

}  // namespace isthmus
