// Exceptions for errors at set-up. Real-time loops never throw.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace typodont {

/// Wrong usage or wrong input. The message names the file, the key or line, the value found and the value expected. The
/// program ends with exit status 2.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  /// Composes the message "FILE: WHERE: found FOUND, expected EXPECTED". Empty parts are omitted.
  Error(std::string_view file, std::string_view where, std::string_view found, std::string_view expected);
};

/// A run that failed although its input was valid, for example because a device was lost. The program ends with exit
/// status 1.
class RunFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace typodont
