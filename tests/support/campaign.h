// Random campaigns are short in every test run and long in ./run stress, which sets TYPODONT_STRESS to a factor.
// TYPODONT_STRESS_SEED sets the first seed of a campaign, so that several campaigns differ.
#pragma once

#include <cstdint>
#include <cstdlib>

namespace typodont::test {

/// Returns the number of repetitions: n multiplied by the factor that ./run stress sets.
inline int campaign(int n) {
  const char* factor = std::getenv("TYPODONT_STRESS");
  return factor ? static_cast<int>(n * std::atof(factor)) : n;
}

/// The first seed of a campaign: `seed`, or the value that the user sets.
inline std::uint64_t campaign_seed(std::uint64_t seed) {
  const char* given = std::getenv("TYPODONT_STRESS_SEED");
  return given ? std::strtoull(given, nullptr, 10) : seed;
}

}  // namespace typodont::test
