// All parsers of data from outside, each as a function that takes bytes. Two programs use the table: `fuzz`, in which
// libFuzzer chooses the bytes by code coverage (./run fuzz), and the stress test, which passes the stored corpus and
// damaged copies of it to every parser in each test run.
#pragma once

#include <cstddef>
#include <ostream>
#include <span>
#include <string_view>

namespace typodont::test {

struct FuzzTarget {
  std::string_view name;  // its corpus lies in tests/fuzz/corpus/NAME
  /// Takes any bytes. Must return normally if they are read and if they are refused (typodont::Error, RunFailure).
  /// Anything else is an error in the parser: a crash, another exception, a message of a sanitizer, or seconds of work.
  void (*eat)(std::span<const std::byte> bytes);
};

std::span<const FuzzTarget> fuzz_targets();

inline std::ostream& operator<<(std::ostream& out, const FuzzTarget& target) {
  return out << target.name;
}

}  // namespace typodont::test
