// "voxel_penalty": tests samples of the head against full and empty voxels, computes the force by springs and dampers,
// and removes whole voxels.
#pragma once

#include "haptics/contact_method.h"

namespace typodont::haptics::voxel_penalty {

inline constexpr std::string_view kName = "voxel_penalty";

struct Parameters {
  int samples = 64;  // number of points on the head's surface, 8 to 1024
  // limit of the number of contacts; with more contacts, their forces are averaged (McNeely 1999, sec. 5.2); 1 to
  // 1024
  int shared_load = 10;
};

/// Reads {"samples": 64, "shared_load": 10}. Throws Error.
SharedContactMethod read(const std::optional<Json>& parameters);

}  // namespace typodont::haptics::voxel_penalty
