// A random campaign repeats a check with random input. Campaigns are short in normal test runs and long in ./run
// stress, which sets TYPODONT_STRESS to a factor.
#pragma once

#include <cstdlib>

namespace typodont::test {

/// Returns the number of repetitions: n multiplied by the factor that ./run stress sets.
inline int campaign(int n) {
  const char* factor = std::getenv("TYPODONT_STRESS");
  return factor ? static_cast<int>(n * std::atof(factor)) : n;
}

}  // namespace typodont::test
