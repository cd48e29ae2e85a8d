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

/// Number of threads for work beside a session. With more than four cores, two of them stay free for servo and picture.
inline std::size_t threads_beside_session() {
  const std::size_t cores = std::thread::hardware_concurrency();
  return std::max(std::min(cores, std::size_t{4}), cores - std::min(cores, std::size_t{2}));
}

/// Calls each(i) for 0 <= i < count on several threads, `block` calls at a time, and waits for all. If a call throws,
/// no new calls begin, and the exception is thrown here. Throws Stopped if `stop` was requested. Any thread.
template <class Each>
void in_parallel(std::size_t count, const Each& each, const std::stop_token& stop = {}, std::size_t block = 32) {
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
  const std::size_t threads = std::min(threads_beside_session(), blocks);
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
