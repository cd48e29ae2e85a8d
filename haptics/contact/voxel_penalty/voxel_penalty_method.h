// The contact model "voxel_penalty": tests samples of the head's surface against full and empty voxels, computes the
// force by springs and dampers, and removes whole voxels.
#pragma once

#include "haptics/contact_method.h"

namespace typodont::haptics::voxel_penalty {

inline constexpr std::string_view kName = "voxel_penalty";

struct Parameters {
  int samples = 64;  // number of samples on the head's surface, 8 to 1024
  // The sum of the springs' forces is divided by the number of samples in contact, but at least by this number (McNeely
  // 1999, sec. 5.2); 1 to 1024.
  int shared_load = 10;
};

/// Creates the method from its parameters in a scene file, for example {"samples": 64, "shared_load": 10}. Throws
/// Error.
SharedContactMethod read(const std::optional<Json>& parameters);

}  // namespace typodont::haptics::voxel_penalty
