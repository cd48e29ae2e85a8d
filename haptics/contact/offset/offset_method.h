// The default contact model "offset": a god-object on the offset surface of a distance field. A cut removes exactly the
// volume through which the head moves (its sweep).
#pragma once

#include "haptics/contact_method.h"

namespace typodont::haptics::offset {

inline constexpr std::string_view kName = "offset", kAlias = "god-object";
SharedContactMethod read(const std::optional<Json>& parameters);

}  // namespace typodont::haptics::offset
