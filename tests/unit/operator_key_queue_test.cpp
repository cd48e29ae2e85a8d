// Tests that the pages get all key events between two frames, in their order.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "engine/app/operator/key_queue.h"

namespace typodont {
namespace {

namespace keys = display::keys;
using Key = KeyQueue::Key;

std::vector<Key> press(int code) {
  return {{code, true}, {code, false}};
}
std::vector<Key> write(char c) {
  return {{std::toupper(c), true}, {0, false, static_cast<std::uint32_t>(c)}, {std::toupper(c), false}};
}

TEST(KeyQueue, KeysAfterAPageChangeGoToTheNewPage) {
  KeyQueue queue;
  queue.add(std::vector<Key>{{keys::kLeftControl, true}, {'H', true}, {'H', false}, {keys::kLeftControl, false}});
  queue.add(write('s'));
  for (int frame = 0; frame < 3; ++frame)
    for (const Key& key : queue.next()) EXPECT_EQ(key.typed, 0u) << "the field does not take text yet";
  std::string typed;
  while (!queue.empty())
    for (const Key& key : queue.next())
      if (key.typed) typed += static_cast<char>(key.typed);
  EXPECT_EQ(typed, "s");
}

TEST(KeyQueue, AKeyGoesDownWithTheControlKeyItWasPressedWith) {
  KeyQueue queue;
  queue.add(std::vector<Key>{{keys::kLeftControl, true}});
  queue.next();
  queue.add(std::vector<Key>{
      {'Z', true}, {keys::kLeftControl, false}, {'Z', false}, {'Y', true}, {keys::kRightControl, true}, {'Y', false}});
  bool control = true;
  std::string pressed;
  while (!queue.empty()) {
    std::string now;
    for (const Key& key : queue.next()) {
      if (key.code >= keys::kLeftShift)
        control = key.down;
      else if (key.down)
        now += static_cast<char>(key.code);
    }
    for (const char c : now) pressed += fmt::format("{}{} ", control ? "Ctrl " : "", c);
  }
  EXPECT_EQ(pressed, "Ctrl Z Y ");
}

TEST(KeyQueue, EscapeAndSpaceAsEmergencyStopOvertakeWaitingKeys) {
  for (const int stop : {static_cast<int>(keys::kEscape), static_cast<int>(' ')}) {
    KeyQueue queue;
    queue.add(press(keys::kTab));
    queue.next(true);
    queue.add(write('a'));
    queue.add(press(stop));
    bool stopped = false;
    for (const Key& key : queue.next(true)) stopped = stopped || (key.code == stop && key.down);
    EXPECT_TRUE(stopped) << stop;
  }
}

TEST(KeyQueue, OnOtherPagesEscapeIsProcessedAfterTheKeyBeforeIt) {
  constexpr int kFilm = keys::kF1 + 3;
  KeyQueue queue;
  queue.add(press(kFilm));
  queue.add(press(keys::kEscape));
  int film = -1, escape = -1;
  for (int frame = 0; !queue.empty(); ++frame) {
    for (const Key& key : queue.next()) {
      if (key.down) (key.code == kFilm ? film : escape) = frame;
    }
  }
  EXPECT_EQ(film, 0);
  EXPECT_GE(escape, 2);
}

TEST(KeyQueue, AHeldKeyThatRepeatsIsDownOnce) {
  KeyQueue queue;
  queue.add(std::vector<Key>{{'P', true}, {'P', true}, {'P', true}});
  EXPECT_EQ(queue.next().size(), 1u);
  EXPECT_TRUE(queue.empty());
  queue.add(std::vector<Key>{{'P', true}, {'P', false}, {-1, true}, {keys::kCount, true}});
  EXPECT_EQ(queue.next().size(), 1u);
  EXPECT_TRUE(queue.empty());
}

TEST(KeyQueue, NoDivisionIntoFramesLosesOrReordersKeys) {
  std::mt19937 dice(11);
  for (int round = 0; round < 200; ++round) {
    KeyQueue queue;
    std::string meant, got;
    const auto take = [&] {
      bool away = false;
      for (const Key& key : queue.next()) {
        if (key.typed) {
          EXPECT_FALSE(away);
          got += static_cast<char>(key.typed);
        } else if (key.down && key.code >= keys::kEscape) {
          away = true;
          got += '|';
        }
      }
    };
    for (int i = 0; i < 30; ++i) {
      if (dice() % 4 == 0) {
        queue.add(press(keys::kTab));
        meant += '|';
      } else {
        const char c = static_cast<char>('a' + dice() % 3);
        queue.add(write(c));
        meant += c;
      }
      if (dice() % 3 == 0) take();
    }
    while (!queue.empty()) take();
    EXPECT_EQ(got, meant);
  }
}

}  // namespace
}  // namespace typodont
