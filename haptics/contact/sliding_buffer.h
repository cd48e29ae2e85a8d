// An array that moves over a larger array without copying: remaining elements keep their addresses, only the start
// moves. The ring of memory is mapped twice in sequence, so the array is contiguous.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <new>
#include <type_traits>
#include <utility>

namespace typodont::haptics {

/// Maps `size` bytes of memory twice in sequence. `size`: multiple of the page size. All pages are touched, so the
/// servo has no page faults. Throws std::bad_alloc.
void* map_twice(std::size_t size);

/// Owns its memory; a copy copies the elements. Functions for set-up allocate and throw std::bad_alloc.
template <class T>
class SlidingBuffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  SlidingBuffer() = default;
  SlidingBuffer(const SlidingBuffer& other) { *this = other; }
  SlidingBuffer(SlidingBuffer&& other) noexcept { swap(other); }
  SlidingBuffer& operator=(const SlidingBuffer& other) {
    if (this == &other) return *this;
    allocate(other.count_);
    std::copy_n(other.data(), count_, data());
    return *this;
  }
  SlidingBuffer& operator=(SlidingBuffer&& other) noexcept {
    swap(other);
    return *this;
  }
  ~SlidingBuffer() { release(); }

  /// Sets the size to `count` and all elements to `value`.
  void assign(std::size_t count, T value) {
    allocate(count);
    std::fill_n(data(), count_, value);
  }
  /// Keeps all elements if `count` is the current size; otherwise sets `count` elements to T{}.
  void resize(std::size_t count) {
    if (count != count_) assign(count, T{});
  }

  /// Moves the array by `by` elements (negative: back). Element i becomes the former element i + by, or is unspecified
  /// if there was none. Copies nothing.
  void slide(std::ptrdiff_t by) noexcept {
    if (ring_ == 0) return;
    const auto ring = static_cast<std::ptrdiff_t>(ring_);
    first_ = static_cast<std::size_t>(((static_cast<std::ptrdiff_t>(first_) + by) % ring + ring) % ring);
  }

  T* data() noexcept { return memory_ + first_; }
  const T* data() const noexcept { return memory_ + first_; }
  T& operator[](std::size_t i) noexcept { return data()[i]; }
  const T& operator[](std::size_t i) const noexcept { return data()[i]; }
  T* begin() noexcept { return data(); }
  T* end() noexcept { return data() + count_; }
  const T* begin() const noexcept { return data(); }
  const T* end() const noexcept { return data() + count_; }
  std::size_t size() const noexcept { return count_; }
  bool empty() const noexcept { return count_ == 0; }
  bool operator==(const SlidingBuffer& other) const noexcept {
    return count_ == other.count_ && std::equal(begin(), end(), other.begin());
  }
  void swap(SlidingBuffer& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(count_, other.count_);
    std::swap(ring_, other.ring_);
    std::swap(first_, other.first_);
  }

 private:
  std::size_t bytes() const noexcept { return ring_ * sizeof(T); }

  void release() noexcept {
    if (memory_) munmap(memory_, 2 * bytes());
    memory_ = nullptr;
    count_ = ring_ = first_ = 0;
  }

  void allocate(std::size_t count) {
    if (count == count_) return;
    release();
    if (count == 0) return;
    const std::size_t page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    const std::size_t size = (count * sizeof(T) + page - 1) / page * page;
    memory_ = static_cast<T*>(map_twice(size));
    count_ = count;
    ring_ = size / sizeof(T);
  }

  T* memory_ = nullptr;
  std::size_t count_ = 0;  // number of elements
  // number of elements after which the memory, which is mapped twice, repeats
  std::size_t ring_ = 0;
  std::size_t first_ = 0;  // index of the array's first element in the ring
};

}  // namespace typodont::haptics
