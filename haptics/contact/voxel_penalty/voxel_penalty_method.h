// "voxel_penalty": samples of the head against full and empty voxels, springs and dampers, removal of whole voxels.
#pragma once

#include "haptics/contact_method.h"

namespace typodont::haptics::voxel_penalty {

inline constexpr std::string_view kName = "voxel_penalty";

struct Parameters {
  int samples = 64;  // points of the head's surface, 8 to 1024
  int shared_load =
      10;  // points in contact from which on their forces are averaged (McNeely 1999, sec. 5.2), 1 to 1024
};

/// {"samples": 64, "shared_load": 10}. Throws Error.
SharedContactMethod read(const std::optional<Json>& parameters);

}  // namespace typodont::haptics::voxel_penalty
