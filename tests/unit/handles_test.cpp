// Tests the table of handles of the C interface alone.
#include "engine/bindings/c/handles.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <random>
#include <thread>
#include <vector>

namespace typodont::bindings {
namespace {

TEST(Handles, AnUnknownHandleIsRefused) {
  int object = 0;
  void* const real = new_handle(Kind::kHand, &object);
  std::mt19937_64 random(7);
  for (int i = 0; i < 200'000; ++i) {
    // Tries random numbers, and numbers that differ from the real handle by one bit.
    const std::uint64_t forged =
        i % 2 ? random() : reinterpret_cast<std::uintptr_t>(real) ^ (std::uint64_t{1} << (random() % 64));
    for (int kind = 1; kind <= 6; ++kind) {
      if (forged == reinterpret_cast<std::uintptr_t>(real)) continue;
      const HeldHandle taken(reinterpret_cast<void*>(forged), static_cast<Kind>(kind));
      ASSERT_EQ(taken.found(), Found::kBadHandle) << forged;
    }
  }
  EXPECT_EQ(HeldHandle(real, Kind::kHand).drop(), &object);
}

TEST(Handles, TheTableIsFullAt4096AndHasRoomAgainForEachThatIsFreed) {
  std::vector<void*> handles;
  int object = 0;
  while (void* const handle = new_handle(Kind::kScene, &object)) handles.push_back(handle);
  EXPECT_EQ(handles.size(), kSlots);
  EXPECT_EQ(HeldHandle(handles[17], Kind::kScene).drop(), &object);
  handles[17] = new_handle(Kind::kScene, &object);
  EXPECT_NE(handles[17], nullptr);
  EXPECT_EQ(new_handle(Kind::kScene, &object), nullptr);
  for (void* const handle : handles) EXPECT_EQ(HeldHandle(handle, Kind::kScene).drop(), &object);
}

// If a second thread could get into an object, ThreadSanitizer would report a race on the object's plain numbers.
TEST(Handles, AnObjectServesOneThreadAtATimeAndIsGoneForAllOnceItIsFreed) {
  struct Object {
    std::uint64_t uses = 0;
    bool gone = false;
  };
  constexpr int kThreads = 4, kObjects = 3, kRounds = 300;
  for (int round = 0; round < kRounds; ++round) {
    std::array<Object, kObjects> objects;
    std::array<void*, kObjects> handles;
    for (std::size_t i = 0; i < kObjects; ++i) handles[i] = new_handle(Kind::kCore, &objects[i]);
    std::atomic<std::uint64_t> held{0};
    std::atomic<int> freed{0};
    const auto use = [&](int seed) {
      std::minstd_rand random(static_cast<unsigned>(seed + 1));
      while (freed < kObjects) {
        HeldHandle taken(handles[random() % kObjects], Kind::kCore);
        if (taken.found() != Found::kHeld) continue;
        auto& object = *static_cast<Object*>(taken.object());
        EXPECT_FALSE(object.gone);
        ++object.uses;
        ++held;
        if (random() % 16 != 0) continue;
        object.gone = true;
        taken.drop();
        ++freed;
      }
    };
    std::vector<std::jthread> threads;
    for (int i = 0; i < kThreads; ++i) threads.emplace_back(use, round * kThreads + i);
    threads.clear();
    EXPECT_EQ(objects[0].uses + objects[1].uses + objects[2].uses, held);
  }
}

}  // namespace
}  // namespace typodont::bindings
