// The contact method "offset" (default): a god-object on the offset surface of a distance field. Cuts are exact sweeps.
#pragma once

#include "haptics/contact_method.h"

namespace typodont::haptics::offset {

inline constexpr std::string_view kName = "offset", kAlias = "god-object";
SharedContactMethod read(Keys& keys);

}  // namespace typodont::haptics::offset
