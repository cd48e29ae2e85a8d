// What drivers made of shaders, kept between runs in a folder of the program's own and checked before a driver looks at
// it: Mesa (22.3) refuses an entry that is damaged, makes it anew at every start, and never replaces it.
#pragma once

#include <vulkan/vulkan.h>

#include <filesystem>

namespace typodont::gpu {

/// From now on this program's devices keep theirs there, and so do drivers that can be told where (Mesa); not where the
/// user has told them. Once, before any device and any other thread. Without it each driver does as it does.
void keep_driver_cache(const std::filesystem::path& folder);

/// Before a driver is loaded: what is no longer as it was left is removed. Once a process.
void check_driver_cache();
/// A device's pipelines as they were kept, or none; null where none are kept.
VkPipelineCache open_pipelines(VkDevice device, const VkPhysicalDeviceProperties& properties);
/// Keeps them, and ends the object.
void close_pipelines(VkDevice device, const VkPhysicalDeviceProperties& properties, VkPipelineCache pipelines);
/// Once the drivers are done: how everything in the folder was left.
void note_driver_cache();

}  // namespace typodont::gpu
