#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "engine/gpu/device.h"

namespace typodont::gpu {
namespace {

TEST(RangeAllocator, AllocatesEachRangeOnceAndMergesFreedRanges) {
  std::mt19937_64 g(7);
  RangeAllocator ranges(10000);
  struct Piece {
    std::uint64_t start, count;
  };
  std::vector<Piece> held;
  std::vector<char> used(10000, 0);
  for (int step = 0; step < 20000; ++step) {
    if (held.empty() || g() % 100 < 55) {
      const std::uint64_t count = 1 + g() % 300, alignment = std::uint64_t{1} << (g() % 5);
      const std::uint64_t start = ranges.allocate(count, alignment);
      if (start == RangeAllocator::kNone) continue;
      ASSERT_EQ(start % alignment, 0u);
      ASSERT_LE(start + count, 10000u);
      for (std::uint64_t i = start; i < start + count; ++i) ASSERT_FALSE(used[i]) << "given out twice";
      std::fill_n(used.begin() + static_cast<long>(start), count, 1);
      held.push_back({start, count});
    } else {
      const std::size_t i = g() % held.size();
      ranges.release(held[i].start, held[i].count);
      std::fill_n(used.begin() + static_cast<long>(held[i].start), held[i].count, 0);
      held.erase(held.begin() + static_cast<long>(i));
    }
    ASSERT_EQ(ranges.free(), static_cast<std::uint64_t>(std::count(used.begin(), used.end(), 0)));
  }
  for (const Piece& p : held) ranges.release(p.start, p.count);
  EXPECT_EQ(ranges.free(), 10000u);
  EXPECT_EQ(ranges.pieces(), 1u);
}

}  // namespace
}  // namespace typodont::gpu
