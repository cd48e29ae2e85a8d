// A replayed tick or cut against the recorded one, column by column, as the session file keeps them.
#pragma once

#include <string_view>

#include "engine/contract/contact.h"

namespace typodont::session {

/// The name of the first column that differs in any bit; empty where none does. Of a tick it leaves out what the servo
/// does not compute: hand and pedal, which it is given, the CPU time, and the fault bits that the loop around it sets.
/// Units other than SI are compared as the file rounds them.
std::string_view differing_column(const ServoTick& replayed, const ServoTick& recorded);
std::string_view differing_column(const Cut& replayed, const Cut& recorded);

}  // namespace typodont::session
