// The contact method "voxel_penalty": springs and dampers on samples of the head inside full voxels. Cuts remove whole
// voxels.
#pragma once

#include "haptics/contact_method.h"

namespace typodont::haptics::voxel_penalty {

inline constexpr std::string_view kName = "voxel_penalty";

struct Parameters {
  int samples = 64;  // number of samples of the head, 8 to 1024
  // The sum of the spring forces is divided by the number of samples in contact, but at least by this number (McNeely
  // 1999, sec. 5.2). Allowed values: 1 to 1024.
  int shared_load = 10;
};

/// Reads the parameters, and creates the method with them. Throws Error.
SharedContactMethod read(Keys& keys);

}  // namespace typodont::haptics::voxel_penalty
