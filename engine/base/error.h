// Exceptions for errors at set-up. Real-time loops never throw.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace typodont {

/// Wrong usage or input: names file, key or line, found and expected value. Exit status 2.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  /// "FILE: WHERE: found FOUND, expected EXPECTED", without empty parts.
  Error(std::string_view file, std::string_view where, std::string_view found, std::string_view expected);
};

/// A run that failed with valid input, for example a lost device. Exit status 1.
class RunFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace typodont
