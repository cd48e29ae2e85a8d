// What options may be: checked while the command line is read, before any work begins. Messages say what was found and
// what was expected, as those about files do.
#pragma once

#include <CLI/CLI.hpp>
#include <initializer_list>
#include <string>

#include "engine/base/partial_file.h"

namespace typodont {

/// A finite number from `least` to `most`.
CLI::Validator number_in(double least, double most);
/// A finite number above 0, up to `most`.
CLI::Validator more_than_zero(double most = 1e9);
/// A whole number from 0 on: a monitor, a channel.
CLI::Validator from_zero();

/// A name that the command may write a file of one of these kinds to: its ending is one of theirs (a device or a FIFO
/// may be called anything), its folder can be written to, and nothing there has to stay (PartialFile).
CLI::Validator writes(std::initializer_list<FileKind> kinds, Over over = Over::kNoInput);

/// Every option of `app` and its commands that is a number takes finite ones only: "nan" passes comparisons, and "inf"
/// means work without end.
void take_finite_numbers_only(CLI::App& app);

/// Throws Error where one of `options` was given although `needed` (in words, "--view section") was not.
void refuse_without(const CLI::App& command, std::initializer_list<const char*> options, bool given,
                    const std::string& needed);

}  // namespace typodont
