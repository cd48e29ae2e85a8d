// Compares a replayed tick or cut with the recorded one. Every column is compared in the precision of the session file.
#pragma once

#include <string_view>

#include "engine/contract/contact.h"

namespace typodont::session {

/// Returns the name of the first column that differs in any bit; empty if all columns are equal. The function skips
/// columns that the servo does not compute: hand and pedal (the servo's input), the CPU time, and fault bits that other
/// code sets. Columns with units other than SI are compared after rounding as in the file.
std::string_view differing_column(const ServoTick& replayed, const ServoTick& recorded);
std::string_view differing_column(const Cut& replayed, const Cut& recorded);

}  // namespace typodont::session
