// Tests the tape between threads. ./run check runs the tests with ThreadSanitizer.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <variant>
#include <vector>

#include "engine/base/event_log.h"
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

TEST(EventLog, EachReaderSeesEveryEventInOrder) {
  EventLog<Event> event_log(16);
  EventLog<Event>::Reader first(event_log), second(event_log);
  Event event;
  EXPECT_FALSE(first.next(event));
  for (std::uint64_t n = 1; n <= 8; ++n) event_log.write(event_of(n));
  for (EventLog<Event>::Reader* reader : {&first, &second}) {
    for (std::uint64_t n = 1; n <= 8; ++n) {
      ASSERT_TRUE(reader->next(event));
      EXPECT_EQ(number_of(event), n);
    }
    EXPECT_FALSE(reader->next(event));
    EXPECT_EQ(reader->lost(), 0u);
  }
}

TEST(EventLog, AnOvertakenReaderCountsTheLostEventsAndReadsOn) {
  EventLog<std::uint64_t> event_log(8);
  EventLog<std::uint64_t>::Reader reader(event_log);
  for (std::uint64_t n = 1; n <= 20; ++n) event_log.write(n);
  std::uint64_t event = 0;
  for (std::uint64_t n = 14; n <= 20; ++n) {
    ASSERT_TRUE(reader.next(event));
    EXPECT_EQ(event, n);
  }
  EXPECT_FALSE(reader.next(event));
  EXPECT_EQ(reader.lost(), 13u);
}

TEST(EventLog, AJumpToTheNewestEventSkipsTheOthersWithoutALoss) {
  EventLog<std::uint64_t> event_log(8);
  EventLog<std::uint64_t>::Reader reader(event_log);
  std::uint64_t event = 0;
  EXPECT_FALSE(reader.newest(event));
  for (std::uint64_t n = 1; n <= 20; ++n) event_log.write(n);
  ASSERT_TRUE(reader.newest(event));
  EXPECT_EQ(event, 20u);
  EXPECT_FALSE(reader.newest(event));
  EXPECT_FALSE(reader.next(event));
  event_log.write(21);
  ASSERT_TRUE(reader.next(event));
  EXPECT_EQ(event, 21u);
  EXPECT_EQ(reader.lost(), 0u);
}

// The tape is so short that the writer overtakes the readers all the time, often while they copy a slot.
TEST(EventLog, NoReaderEverSeesAMixtureOfTwoEventsAndAllEventsAreReadOrCounted) {
  constexpr std::uint64_t kLast = 100'000;
  EventLog<Event> event_log(8);
  std::vector<std::jthread> readers;
  std::atomic<std::uint64_t> read_total{0}, lost_total{0}, ready{0};
  for (int r = 0; r < 3; ++r) {
    readers.emplace_back([&, newest = r == 2] {
      EventLog<Event>::Reader reader(event_log);
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
  for (std::uint64_t n = 1; n <= kLast; ++n) event_log.write(event_of(n));
  readers.clear();
  EXPECT_GT(read_total, 2u);
  EXPECT_GT(lost_total, 0u);
}

TEST(EventLog, AllocatesNothingOnceBuilt) {
  EventLog<Event> event_log(128);
  EventLog<Event>::Reader all(event_log), latest(event_log);
  Event event;
  const test::NoAlloc guard;
  for (std::uint64_t n = 1; n <= 1000; ++n) {
    event_log.write(event_of(n));
    all.next(event);
    latest.newest(event);
  }
  EXPECT_EQ(guard.count(), 0u);
}

}  // namespace
}  // namespace typodont
