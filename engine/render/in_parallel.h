// A loop whose iterations several threads share.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace typodont::render {

/// Calls each(i) for 0 <= i < count on up to four threads, and returns when all calls have returned. A thread takes
/// `block` calls at a time. Any thread.
template <class Each>
void in_parallel(std::size_t count, const Each& each, std::size_t block = 32) {
  constexpr std::size_t kMostThreads = 4;
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t first = next.fetch_add(block); first < count; first = next.fetch_add(block))
      for (std::size_t i = first; i < std::min(first + block, count); ++i) each(i);
  };
  // no more threads than blocks, because a thread without work still takes time to start
  const std::size_t blocks = (count + block - 1) / block;
  const std::size_t threads = std::min({kMostThreads, std::size_t{std::thread::hardware_concurrency()}, blocks});
  std::vector<std::jthread> others;
  for (std::size_t t = 1; t < threads; ++t) others.emplace_back(work);
  work();
}

}  // namespace typodont::render
