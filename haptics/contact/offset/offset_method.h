// "offset", the default: a god-object on a field's offset surface; cuts are exact sweeps.
#pragma once

#include "haptics/contact_method.h"

namespace typodont::haptics::offset {

inline constexpr std::string_view kName = "offset", kAlias = "god-object";
SharedContactMethod read(const std::optional<Json>& parameters);

}  // namespace typodont::haptics::offset
