// "voxel_penalty": samples of the head against full voxels; springs and dampers; whole voxels are removed.
#pragma once

#include "haptics/contact_method.h"

namespace typodont::haptics::voxel_penalty {

inline constexpr std::string_view kName = "voxel_penalty";

struct Parameters {
  int samples = 64;  // 8 to 1024
  // Least divisor of the summed force, else samples in contact (McNeely 1999, sec. 5.2); 1 to 1024.
  int shared_load = 10;
};

/// For example {"samples": 64, "shared_load": 10}. Throws Error.
SharedContactMethod read(const std::optional<Json>& parameters);

}  // namespace typodont::haptics::voxel_penalty
