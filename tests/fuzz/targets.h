// Every parser of outside data as a function of bytes. One table serves two programs: `fuzz`, which libFuzzer drives by
// coverage (./run fuzz), and the stress test that feeds the kept corpus and damaged copies of it in every test run.
#pragma once

#include <cstddef>
#include <ostream>
#include <span>
#include <string_view>

namespace typodont::test {

struct FuzzTarget {
  std::string_view name;  // its corpus lies in tests/fuzz/corpus/NAME
  /// Takes any bytes. Returns normally whether they were read or refused (typodont::Error, RunFailure); anything else —
  /// a crash, another exception, a sanitizer's complaint, seconds of work — is a find.
  void (*eat)(std::span<const std::byte> bytes);
};

std::span<const FuzzTarget> fuzz_targets();

inline std::ostream& operator<<(std::ostream& out, const FuzzTarget& target) {
  return out << target.name;
}

}  // namespace typodont::test
