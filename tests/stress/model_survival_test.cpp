// The short version of `typodont bench stress` (docs/stress.md): tests what the simple contact models withstand.
#include <gtest/gtest.h>

#include <set>
#include <string>

#include "haptics/bench.h"

namespace typodont {
namespace {

const std::vector<BenchRow>& rows() {
  static const auto all = [] {
    haptics::StressBenchOptions options;
    options.quick = true;
    options.models = {"offset", "voxel_penalty"};
    return haptics::bench_stress(options);
  }();
  return all;
}

/// Returns the names of this model's rows whose result is beyond the limit.
std::set<std::string> failed(const std::string& model) {
  std::set<std::string> names;
  for (const BenchRow& row : rows())
    if (row.name.find(", " + model + ": ") != std::string::npos && row.ratio > 1) names.insert(row.name);
  return names;
}

TEST(Survival, TheDefaultModelSurvivesEveryCampaign) {
  EXPECT_TRUE(failed("offset").empty()) << *failed("offset").begin();
}

// The two cases are a thin wall, and a tip that is pressed deeper than its radius. Only a model with a proxy can hold
// them.
TEST(Survival, APenaltyModelFailsWhereAProxyIsNeeded) {
  EXPECT_EQ(failed("voxel_penalty"),
            (std::set<std::string>{"thin wall, voxel_penalty: escaped", "fast probe, voxel_penalty: holes",
                                   "fast probe, voxel_penalty: force off"}));
}

TEST(Survival, EveryStressTestHasAMeasuredValueAndALimit) {
  std::set<std::string> campaigns;
  for (const BenchRow& row : rows()) {
    campaigns.insert(row.name.substr(0, row.name.find(',')));
    EXPECT_GE(row.ratio, 0) << row.name;
    EXPECT_FALSE(row.baseline.empty()) << row.name;
  }
  EXPECT_EQ(campaigns, (std::set<std::string>{"hostile hand", "nonsense", "carver stalls", "uneven clock", "200 N",
                                              "fast probe", "thin wall"}));
}

}  // namespace
}  // namespace typodont
