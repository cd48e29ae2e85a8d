// Random campaigns are short in every test run and long in ./run stress, which sets TYPODONT_STRESS to a factor.
#pragma once

#include <cstdlib>

namespace typodont::test {

/// n repetitions, multiplied by the factor that ./run stress sets.
inline int campaign(int n) {
  const char* factor = std::getenv("TYPODONT_STRESS");
  return factor ? static_cast<int>(n * std::atof(factor)) : n;
}

}  // namespace typodont::test
