// A loop whose iterations several threads share.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <stop_token>
#include <system_error>
#include <thread>
#include <vector>

namespace typodont {

/// Thrown by in_parallel() if a stop of the work was requested.
struct Stopped {};

/// Largest number of threads for background work: all cores except two, which servo and picture need; at least four.
inline std::size_t background_threads() {
  return std::max(std::size_t{6}, std::size_t{std::thread::hardware_concurrency()}) - 2;
}

/// Calls each(i) for 0 <= i < count on up to `max_threads` threads, `block` calls at a time, and waits for all. If a
/// call throws, no new calls begin, and the exception is thrown here. Throws Stopped if `stop` was requested. Any
/// thread.
template <class Each>
void in_parallel(std::size_t count, const Each& each, const std::stop_token& stop = {}, std::size_t block = 32,
                 std::size_t max_threads = 4) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::once_flag failed;
  const auto work = [&]() noexcept {
    try {
      for (std::size_t first = next.fetch_add(block); first < count; first = next.fetch_add(block)) {
        if (stop.stop_requested()) throw Stopped();
        for (std::size_t i = first; i < std::min(first + block, count); ++i) each(i);
      }
    } catch (...) {
      std::call_once(failed, [&] { failure = std::current_exception(); });
      next = count;
    }
  };
  // No more threads than blocks: a thread without work still takes time to start.
  const std::size_t blocks = (count + block - 1) / block;
  const std::size_t threads = std::min({max_threads, std::size_t{std::thread::hardware_concurrency()}, blocks});
  {
    std::vector<std::jthread> others;
    try {
      for (std::size_t t = 1; t < threads; ++t) others.emplace_back(work);
    } catch (const std::system_error&) {
    }
    work();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace typodont
