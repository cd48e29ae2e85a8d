// Compares a replayed tick or cut with the recorded one, column by column, in the precision of the session file.
#pragma once

#include <string_view>

#include "engine/contract/contact.h"

namespace typodont::session {

/// Name of the first column that differs in any bit; empty if all columns are equal. Columns that the servo does not
/// compute are skipped: hand and pedal (its input), the CPU time, and fault bits from the surrounding loop. Columns
/// in units other than SI are compared as the file rounds them.
std::string_view differing_column(const ServoTick& replayed, const ServoTick& recorded);
std::string_view differing_column(const Cut& replayed, const Cut& recorded);

}  // namespace typodont::session
