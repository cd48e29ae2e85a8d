// Prints the rows of the benchmark. Checks only ratios of medians, with wide limits, because these hold on any machine.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "audio/bench.h"

namespace typodont::audio {
namespace {

class Bench : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    rows_ = audio_bench({.recording = "assets/sounds/micromotor_steady.wav"});
    fmt::print("{:<26}{:<22}{:>12} {:<18}{:>10} {:>9}  of {}\n", "name", "knob", "error", "", "ns/sample", "ratio",
               "baseline");
    for (const auto& r : rows_) {
      fmt::print("{:<26}{:<22}{:>12.3g} {:<18}{:>10.2f} {:>9.4f}  {}\n", r.name, r.knob, r.error, r.error_unit,
                 r.time_ns, r.ratio, r.baseline);
    }
  }
  static const BenchRow& row(const std::string& name, const std::string& knob, const std::string& unit = "") {
    const auto found = std::find_if(rows_.begin(), rows_.end(), [&](const BenchRow& r) {
      return r.name == name && r.knob == knob && (unit.empty() || r.error_unit == unit);
    });
    if (found == rows_.end()) throw std::out_of_range(name + " " + knob);
    return *found;
  }
  static inline std::vector<BenchRow> rows_;
};

TEST_F(Bench, BlockFilterOfOrder300TakesAtMostTwiceTheTimeOfItsMultiplyAdds) {
  EXPECT_LT(row("filter block float", "order 300").ratio, 2.0);
}

TEST_F(Bench, BlockFilterOfOrder300IsAtLeastTwiceAsFastAsASimpleLoop) {
  EXPECT_GT(row("filter direct float", "order 300").ratio, 2.0);
}

TEST_F(Bench, FloatAndDoubleDifferInaudibly) {
  for (const char* order : {"order 16", "order 300", "order 600"}) {
    EXPECT_LT(row("filter block float", order).error, 1e-4) << order;
    EXPECT_LT(row("filter block double", order).error, 1e-11) << order;
    EXPECT_LT(row("filter lattice double", order).error, 1e-10) << order;
  }
}

TEST_F(Bench, DistanceToTheRecordingFallsWithTheOrderAndIsUnderOneDecibelAt300) {
  const auto distance = [](const char* order) { return row("model", order, "dB log-spectral").error; };
  EXPECT_GT(distance("order 4"), distance("order 16"));
  EXPECT_GT(distance("order 16"), distance("order 100"));
  EXPECT_GT(distance("order 100"), distance("order 300"));
  EXPECT_LT(distance("order 300"), 1.0);
}

TEST_F(Bench, SilenceCostsLessThanATenthOfIdlingAndDrillingLessThanOnePercentOfACore) {
  EXPECT_LT(row("synth", "off").time_ns, 0.1 * row("synth", "idle at free speed").time_ns);
  EXPECT_LT(row("synth", "working in enamel").ratio, 0.01);
}

}  // namespace
}  // namespace typodont::audio
