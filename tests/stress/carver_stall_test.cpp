// Tests sessions in which the carver does nothing for 5 ms to 5 s. A simulated hand slides, drills, taps, withdraws or
// comes down from the air, with any tool, at 1 and 4 kHz. The normal run is short; ./run stress makes it long.
#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "engine/contract/contact.h"
#include "tests/support/campaign.h"
#include "tests/support/carver_stalls.h"

namespace typodont::test {
namespace {

class CarverStall : public testing::TestWithParam<StallGesture> {};

TEST_P(CarverStall, AStallOfAnyLengthAddsNoForceStepAndNoEnergy) {
  // During the stall, the tool can get into tissue that its old patch does not contain. With the new patch it meets
  // this tissue as a landing hand does.
  const bool drills = GetParam() == StallGesture::kDrill;
  const double landing = drills ? 0.01 : 0.15, energy = 1e-3;  // N, J
  std::uint32_t faults = 0;
  for (const double rate : {1000.0, 4000.0}) {
    for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(campaign(1)); ++seed) {
      const StallResult without = simulate_stall({GetParam(), 0, rate, seed});
      for (const double stall :
           rate > 1000 ? std::vector<double>{0.1, 0.5} : std::vector<double>{0.02, 0.2, 1.0, 5.0}) {
        const StallResult felt = simulate_stall({GetParam(), stall, rate, seed});
        SCOPED_TRACE(testing::Message() << felt.tool << ", seed " << seed << ", " << stall << " s, " << rate << " Hz");
        EXPECT_LE(felt.worst_step, without.worst_step + landing);
        EXPECT_LE(felt.energy, without.energy + energy);
        EXPECT_LE(felt.max_force, without.max_force + 1.5);
        faults |= felt.faults;
      }
    }
  }
  EXPECT_TRUE(drills || (faults & bits(Fault::kPatchEdge)) != 0) << "no tool left its patch";
}

TEST_P(CarverStall, APenaltyMethodFeelsNoMissingTissue) {
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(campaign(1)); ++seed) {
    for (const auto& [stall, rate] : {std::pair{0.2, 4000.0}, {1.0, 1000.0}}) {
      StallRun run{GetParam(), stall, rate, seed, "voxel_penalty"};
      const StallResult felt = simulate_stall(run);
      run.stalls = false;
      const StallResult without = simulate_stall(run);
      SCOPED_TRACE(testing::Message() << felt.tool << ", seed " << seed << ", " << stall << " s");
      // A tool that drops into missing tissue has not worked for the energy of its springs. Then the energy ledger
      // holds the force, in steps, as it does after each deep contact of this method.
      if (GetParam() != StallGesture::kDropIn) {
        EXPECT_LE(felt.worst_step, without.worst_step + 0.15);
      }
      EXPECT_LE(felt.energy, without.energy + 1e-3);
      EXPECT_LE(felt.max_force, without.max_force + 0.65);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Gestures, CarverStall, testing::ValuesIn(kStallGestures), [](const auto& gesture) {
  std::string name = name_of(gesture.param);
  std::erase(name, ' ');
  return name;
});

}  // namespace
}  // namespace typodont::test
