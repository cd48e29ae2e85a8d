// Tests channels between threads. ./run check runs them with ThreadSanitizer.
#include "engine/base/latest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <stop_token>
#include <thread>

#include "engine/base/ring.h"
#include "tests/support/no_alloc.h"

namespace typodont {
namespace {

struct Block {
  std::uint64_t words[64] = {};
};

TEST(Latest, NoBufferIsEverHeldByTwoThreads) {
  Latest<Block> latest;
  EXPECT_FALSE(latest.take_back()) << "nothing was published";
  for (auto& w : latest.back().words) w = 1;
  latest.publish();
  ASSERT_TRUE(latest.take_back());
  EXPECT_FALSE(latest.fetch());
  EXPECT_EQ(latest.back().words[0], 1u);
  latest.publish();
  ASSERT_TRUE(latest.fetch());
  EXPECT_FALSE(latest.take_back()) << "the reader has it";
  ASSERT_TRUE(latest.give_back());
  ASSERT_TRUE(latest.take_back());
  latest.publish();

  constexpr std::uint64_t kLast = 100'000;
  std::atomic<std::uint64_t> given_back = 0;
  std::jthread writer([&](const std::stop_token& stop) {
    for (std::uint64_t i = 2; i <= kLast; ++i) {
      // On one core, the reader may not have had a turn until now. So the writer waits for it once.
      while (i == kLast / 2 && given_back == 0 && !stop.stop_requested()) std::this_thread::yield();
      const bool mine = latest.take_back();
      for (auto& w : latest.back().words) {
        if (mine && w != i - 1) std::abort();
        w = i;
      }
      latest.publish();
    }
  });
  std::uint64_t seen = 1;
  while (seen < kLast) {
    if (!latest.fetch()) continue;
    const Block block = latest.front();
    for (const auto w : block.words) ASSERT_EQ(w, block.words[0]);
    ASSERT_GE(block.words[0], seen);
    seen = block.words[0];
    if (seen < kLast && latest.give_back()) ++given_back;
  }
}

TEST(Latest, TheWriterTakesTheSlotThatTheReaderReturnedLast) {
  Latest<int> latest(0);
  for (int i = 1; i <= 3; ++i) {
    latest.publish(i);
    ASSERT_TRUE(latest.fetch());
  }
  latest.front() = -3;  // the reader's own value
  latest.take_returned();
  EXPECT_NE(latest.back(), -3) << "the reader has not returned it yet";
  latest.hand_back();
  EXPECT_FALSE(latest.fetch()) << "a returned slot is no new value";
  EXPECT_FALSE(latest.take_back()) << "nor one that the writer has published";
  latest.take_returned();
  EXPECT_EQ(latest.back(), -3);
  latest.publish(4);
  latest.hand_back();
  ASSERT_TRUE(latest.fetch()) << "a new value is not lost when the reader returns a slot";
  EXPECT_EQ(latest.front(), 4);
}

TEST(Latest, AReaderNeverSeesHalfAValueAndNeverGoesBackAlsoWhenSlotsAreReturned) {
  constexpr std::uint64_t kLast = 300'000;
  Latest<Block> latest;
  std::jthread writer([&] {
    for (std::uint64_t i = 1; i <= kLast; ++i) {
      if (i % 3) latest.take_returned();
      std::ranges::fill(latest.back().words, i);
      latest.publish();
    }
  });
  std::uint64_t seen = 0;
  while (seen < kLast) {
    if (seen % 2) latest.hand_back();
    if (!latest.fetch()) continue;
    const Block block = latest.front();
    for (const auto w : block.words) ASSERT_EQ(w, block.words[0]);
    ASSERT_GT(block.words[0], seen);
    seen = block.words[0];
    // The reader may change its value, as the servo does when it adopts a patch.
    std::ranges::fill(latest.front().words, 0);
  }
}

// The value is so small that the two threads often meet at the moment when one reads it and the other withdraws it.
TEST(Latest, AWithdrawnValueIsNeverRead) {
  constexpr std::uint64_t kLast = 100'000;
  for (int round = 0; round < 10; ++round) {
    Latest<std::uint64_t> latest;
    latest.publish(1);
    std::jthread writer([&] {
      for (std::uint64_t i = 2; i <= kLast; ++i) {
        latest.take_back();
        latest.publish(i);
      }
    });
    std::uint64_t seen = 0;
    while (seen < kLast) {
      if (!latest.fetch()) continue;
      ASSERT_GT(latest.front(), seen);
      seen = latest.front();
    }
  }
}

TEST(Ring, KeepsOrderAcrossThreadsAndCountsDroppedValues) {
  Ring<std::uint64_t> ring(1024);
  constexpr std::uint64_t kLast = 200'000;
  std::jthread writer([&] {
    for (std::uint64_t i = 1; i <= kLast; ++i) ring.push(i);
    ring.push(kLast + 1);
  });
  std::uint64_t last = 0, count = 0, value = 0;
  writer.join();
  while (ring.pop(value)) {
    ASSERT_GT(value, last);
    last = value;
    ++count;
  }
  EXPECT_EQ(count + ring.dropped(), kLast + 1);
}

TEST(Channels, AllocateNothingOnceBuilt) {
  Latest<Block> latest;
  Ring<Block> ring(64);
  const Block block;
  Block out;
  test::NoAlloc guard;
  for (int i = 0; i < 1000; ++i) {
    latest.publish(block);
    latest.fetch();
    ring.push(block);
    ring.pop(out);
  }
  EXPECT_EQ(guard.count(), 0u);
}

}  // namespace
}  // namespace typodont
