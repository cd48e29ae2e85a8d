// Force steps of hands that push every tool into the molar with a constant force (docs/passivity.md).
#include <atomic>
#include <future>
#include <thread>

#include "tests/bench/bench.h"
#include "tests/support/constant_push.h"

namespace typodont::bench {

namespace {

/// `max_excess`: N, limit for the part of a force step beyond the hand's own motion.
void add_hands(const char* what, test::ToolKind kind, std::uint32_t hands, double max_excess = 0) {
  add(fmt::format("{} {}", hands, what), [=](benchmark::State& state) {
    const auto tools = test::tools_of(kind);
    const haptics::TissueVolume tissue = test::pushed_tissue();
    std::vector<test::PushResult> results(hands);
    std::atomic<std::uint32_t> next{0};
    std::vector<std::future<void>> workers;
    for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i)
      workers.push_back(std::async(std::launch::async, [&] {
        for (std::uint32_t seed; (seed = next++) < hands;)
          results[seed] = test::simulate_push(test::random_push(tools, seed), tissue);
      }));
    for (auto& worker : workers) worker.get();
    double beyond = 0, excess = 0, largest = 0, later = 0, energy = 0;
    for (const test::PushResult& felt : results) {
      if (felt.begins_inside) continue;  // led out of the tissue without cutting, which turns the force faster
      beyond += felt.any.over > 0;
      excess = std::max(excess, felt.any.over);
      largest = std::max(largest, felt.any.largest.size);
      later += felt.after_landing.largest.size > test::kPushStep;
      energy = std::max(energy, -felt.min_energy);
    }
    state.counters["hands_beyond_motion"] = beyond;
    state.counters["excess_N"] = excess;
    state.counters["largest_step_N"] = largest;
    state.counters["hands_with_step_after_landing"] = later;
    state.counters["energy_uJ"] = 1e6 * energy;
    require(excess <= max_excess,
            fmt::format("hands that start outside tissue feel no step over {} N beyond their own motion", max_excess));
  });
}

}  // namespace

void add_cases() {
  add_hands("hands", test::ToolKind::kTurns, smoke() ? 4 : 2000);
  add_hands("hands that scrape", test::ToolKind::kScrapes, smoke() ? 4 : 400);
  // These tools give full stiffness and damping from the first tick.
  add_hands("hands that touch", test::ToolKind::kTouches, smoke() ? 4 : 400, 1.0);
}

}  // namespace typodont::bench
