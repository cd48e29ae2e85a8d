// Compares a replayed tick or cut with the recorded one, column by column, in the precision of the session file.
#pragma once

#include <string_view>

#include "engine/contract/contact.h"

namespace typodont::session {

/// Name of the first column that differs in any bit; empty if none does. Columns of a tick that the servo does not
/// compute are skipped: hand and pedal (its input), the CPU time, and fault bits that the loop around it sets. Units
/// other than SI are compared as the file rounds them.
std::string_view differing_column(const ServoTick& replayed, const ServoTick& recorded);
std::string_view differing_column(const Cut& replayed, const Cut& recorded);

}  // namespace typodont::session
