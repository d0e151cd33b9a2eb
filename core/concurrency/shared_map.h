// A sorted map whose copies share what is the same in them.
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

namespace isthmus {

// A copy costs one pointer. Setting or erasing one of n values copies a chunk of at most kChunk
// pointers and a list of some n / kChunk; the other chunks, and all values, are shared with earlier
// copies, which do not change. Reading needs no lock while nobody changes the same copy; copies in
// different threads do not touch each other.
//
// Two levels, and not a balanced tree: of 10,000 values a change copies some 200 pointers, a
// microsecond or two, and going through all of them is as fast as through a vector of pointers.
template <typename Key, typename Value>
class SharedMap {
 public:
  static constexpr size_t kChunk = 64;

 private:
  struct Item {
    Key key;
    std::shared_ptr<const Value> value;
  };
  using Chunk = std::vector<Item>;  // In order of key, never empty.
  using Chunks = std::vector<std::shared_ptr<const Chunk>>;

 public:
  // In order of key; valid as long as the map it belongs to does not change.
  class const_iterator {
   public:
    using iterator_category = std::forward_iterator_tag;
    using difference_type = std::ptrdiff_t;
    using value_type = std::pair<const Key&, const Value&>;
    using pointer = void;
    using reference = value_type;

    const_iterator() = default;
    const Key& key() const { return item().key; }
    const Value& value() const { return *item().value; }
    const std::shared_ptr<const Value>& shared() const { return item().value; }
    value_type operator*() const { return {key(), value()}; }
    const_iterator& operator++() {
      if (++in_chunk_ == (*chunks_)[chunk_]->size()) {
        ++chunk_;
        in_chunk_ = 0;
      }
      return *this;
    }
    friend bool operator==(const const_iterator& a, const const_iterator& b) {
      return a.chunk_ == b.chunk_ && a.in_chunk_ == b.in_chunk_;
    }

   private:
    friend class SharedMap;
    const_iterator(const Chunks* chunks, size_t chunk, size_t in_chunk)
        : chunks_(chunks), chunk_(chunk), in_chunk_(in_chunk) {}
    const Item& item() const { return (*(*chunks_)[chunk_])[in_chunk_]; }

    const Chunks* chunks_ = nullptr;
    size_t chunk_ = 0, in_chunk_ = 0;
  };

  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const_iterator begin() const { return {chunks_.get(), 0, 0}; }
  const_iterator end() const { return {chunks_.get(), chunks_->size(), 0}; }
  // The last value of a map that is not empty.
  const Value& back() const { return *chunks_->back()->back().value; }

  // The first whose key is not before this one.
  const_iterator lower_bound(const Key& key) const {
    const size_t chunk = ChunkOf(key);
    if (chunk == chunks_->size()) return end();
    return {chunks_.get(), chunk, PlaceIn(*(*chunks_)[chunk], key)};
  }
  // end() where there is none.
  const_iterator find(const Key& key) const {
    const const_iterator it = lower_bound(key);
    return it == end() || key < it.key() ? end() : it;
  }
  // Null if there is none; lives as long as a map that has it.
  const Value* Find(const Key& key) const {
    const const_iterator it = find(key);
    return it == end() ? nullptr : &it.value();
  }
  // Null if there is none; lives as long as anybody has it.
  std::shared_ptr<const Value> Get(const Key& key) const {
    const const_iterator it = find(key);
    return it == end() ? nullptr : it.shared();
  }
  bool contains(const Key& key) const { return Find(key) != nullptr; }

  // Adds a value, or puts another in its place.
  void Set(const Key& key, std::shared_ptr<const Value> value) {
    auto chunks = std::make_shared<Chunks>(*chunks_);
    size_t at = ChunkOf(key);
    const bool is_last = at == chunks->size();
    if (is_last && (chunks->empty() || chunks->back()->size() >= kChunk)) {
      chunks->push_back(std::make_shared<const Chunk>(Chunk{{key, std::move(value)}}));
      ++size_;
    } else {
      if (is_last) --at;
      auto chunk = std::make_shared<Chunk>(*(*chunks)[at]);
      const auto place = chunk->begin() + static_cast<std::ptrdiff_t>(PlaceIn(*chunk, key));
      if (place != chunk->end() && !(key < place->key)) {
        place->value = std::move(value);
      } else {
        chunk->insert(place, Item{key, std::move(value)});
        ++size_;
      }
      if (chunk->size() > kChunk) {
        const auto middle = chunk->begin() + kChunk / 2;
        auto second = std::make_shared<const Chunk>(middle, chunk->end());
        chunk->erase(middle, chunk->end());
        chunks->insert(chunks->begin() + static_cast<std::ptrdiff_t>(at) + 1, std::move(second));
      }
      (*chunks)[at] = std::move(chunk);
    }
    chunks_ = std::move(chunks);
  }
  void Set(const Key& key, Value value) {
    Set(key, std::make_shared<const Value>(std::move(value)));
  }

  // Returns how many went.
  template <typename Predicate>
  size_t EraseIf(const Predicate& is_gone) {
    auto chunks = std::make_shared<Chunks>();
    size_t gone = 0;
    for (const std::shared_ptr<const Chunk>& chunk : *chunks_) {
      Chunk left;
      for (const Item& item : *chunk) {
        if (!is_gone(item.key, *item.value)) left.push_back(item);
      }
      gone += chunk->size() - left.size();
      if (left.size() == chunk->size()) {
        chunks->push_back(chunk);
      } else if (!left.empty()) {
        chunks->push_back(std::make_shared<const Chunk>(std::move(left)));
      }
    }
    if (gone > 0) chunks_ = std::move(chunks);
    size_ -= gone;
    return gone;
  }
  // Returns whether there was one.
  bool Erase(const Key& key) {
    const size_t at = ChunkOf(key);
    if (at == chunks_->size()) return false;
    const size_t place = PlaceIn(*(*chunks_)[at], key);
    if (key < (*(*chunks_)[at])[place].key) return false;
    auto chunks = std::make_shared<Chunks>(*chunks_);
    auto chunk = std::make_shared<Chunk>(*(*chunks)[at]);
    chunk->erase(chunk->begin() + static_cast<std::ptrdiff_t>(place));
    if (chunk->empty()) {
      chunks->erase(chunks->begin() + static_cast<std::ptrdiff_t>(at));
    } else {
      (*chunks)[at] = std::move(chunk);
    }
    chunks_ = std::move(chunks);
    --size_;
    return true;
  }

 private:
  // The chunk that has the key if any has: the first that does not end before it.
  size_t ChunkOf(const Key& key) const {
    const auto it =
        std::lower_bound(chunks_->begin(), chunks_->end(), key,
                         [](const auto& chunk, const Key& k) { return chunk->back().key < k; });
    return static_cast<size_t>(it - chunks_->begin());
  }
  static size_t PlaceIn(const Chunk& chunk, const Key& key) {
    const auto it = std::lower_bound(chunk.begin(), chunk.end(), key,
                                     [](const Item& item, const Key& k) { return item.key < k; });
    return static_cast<size_t>(it - chunk.begin());
  }

  std::shared_ptr<const Chunks> chunks_ = std::make_shared<const Chunks>();
  size_t size_ = 0;
};

}  // namespace isthmus
