// Tests the tape between threads. ./run check runs the tests with ThreadSanitizer.
#include "engine/base/tape.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <variant>
#include <vector>

#include "tests/support/no_alloc.h"

namespace typodont {
namespace {

struct Long {
  std::uint64_t words[60] = {};
};
struct Short {
  std::uint32_t value = 0;
};
using Event = std::variant<Long, Short>;

Event event_of(std::uint64_t n) {
  if (n % 3 == 0) return Short{static_cast<std::uint32_t>(n)};
  Long event;
  for (auto& w : event.words) w = n;
  return event;
}

/// Returns the number of the event; 0 if it is a mixture of two events.
std::uint64_t number_of(const Event& event) {
  if (const auto* s = std::get_if<Short>(&event)) return s->value;
  const auto& words = std::get<Long>(event).words;
  for (const auto w : words)
    if (w != words[0]) return 0;
  return words[0];
}

TEST(Tape, EachReaderSeesEveryEventInOrder) {
  Tape<Event> tape(16);
  Tape<Event>::Reader first(tape), second(tape);
  Event event;
  EXPECT_FALSE(first.next(event));
  for (std::uint64_t n = 1; n <= 8; ++n) tape.write(event_of(n));
  for (Tape<Event>::Reader* reader : {&first, &second}) {
    for (std::uint64_t n = 1; n <= 8; ++n) {
      ASSERT_TRUE(reader->next(event));
      EXPECT_EQ(number_of(event), n);
    }
    EXPECT_FALSE(reader->next(event));
    EXPECT_EQ(reader->lost(), 0u);
  }
}

TEST(Tape, AnOvertakenReaderCountsTheLostEventsAndReadsOn) {
  Tape<std::uint64_t> tape(8);
  Tape<std::uint64_t>::Reader reader(tape);
  for (std::uint64_t n = 1; n <= 20; ++n) tape.write(n);
  std::uint64_t event = 0;
  for (std::uint64_t n = 14; n <= 20; ++n) {
    ASSERT_TRUE(reader.next(event));
    EXPECT_EQ(event, n);
  }
  EXPECT_FALSE(reader.next(event));
  EXPECT_EQ(reader.lost(), 13u);
}

TEST(Tape, AJumpToTheNewestEventSkipsTheOthersWithoutALoss) {
  Tape<std::uint64_t> tape(8);
  Tape<std::uint64_t>::Reader reader(tape);
  std::uint64_t event = 0;
  EXPECT_FALSE(reader.newest(event));
  for (std::uint64_t n = 1; n <= 20; ++n) tape.write(n);
  ASSERT_TRUE(reader.newest(event));
  EXPECT_EQ(event, 20u);
  EXPECT_FALSE(reader.newest(event));
  EXPECT_FALSE(reader.next(event));
  tape.write(21);
  ASSERT_TRUE(reader.next(event));
  EXPECT_EQ(event, 21u);
  EXPECT_EQ(reader.lost(), 0u);
}

// The tape is so short that the writer overtakes the readers all the time, often while they copy a slot.
TEST(Tape, NoReaderEverSeesAMixtureOfTwoEventsAndAllEventsAreReadOrCounted) {
  constexpr std::uint64_t kLast = 100'000;
  Tape<Event> tape(8);
  std::vector<std::jthread> readers;
  std::atomic<std::uint64_t> read_total{0}, lost_total{0}, ready{0};
  for (int r = 0; r < 3; ++r) {
    readers.emplace_back([&, newest = r == 2] {
      Tape<Event>::Reader reader(tape);
      std::uint64_t last = 0, read = 0;
      Event event;
      ++ready;
      while (last < kLast) {
        if (!(newest ? reader.newest(event) : reader.next(event))) continue;
        const std::uint64_t n = number_of(event);
        ASSERT_GT(n, last);
        last = n;
        ++read;
      }
      if (!newest) {
        EXPECT_EQ(read + reader.lost(), kLast);
      }
      read_total += read, lost_total += reader.lost();
    });
  }
  while (ready < 3) std::this_thread::yield();
  for (std::uint64_t n = 1; n <= kLast; ++n) tape.write(event_of(n));
  readers.clear();
  EXPECT_GT(read_total, 2u);
  EXPECT_GT(lost_total, 0u);
}

TEST(Tape, AllocatesNothingOnceBuilt) {
  Tape<Event> tape(128);
  Tape<Event>::Reader all(tape), latest(tape);
  Event event;
  const test::NoAlloc guard;
  for (std::uint64_t n = 1; n <= 1000; ++n) {
    tape.write(event_of(n));
    all.next(event);
    latest.newest(event);
  }
  EXPECT_EQ(guard.count(), 0u);
}

}  // namespace
}  // namespace typodont
