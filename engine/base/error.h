// Exceptions for set-up errors, with exact messages. Real-time loops never throw.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace typodont {

/// Bad usage or bad input: names the file, the key or line, what was found and what was expected. Exit status 2.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
  /// Composes the message "FILE: WHERE: found FOUND, expected EXPECTED"; empty parts are omitted.
  Error(std::string_view file, std::string_view where, std::string_view found, std::string_view expected);
};

/// A run that failed although its input was good (a device lost, a replay that differs). Exit status 1.
class RunFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace typodont
