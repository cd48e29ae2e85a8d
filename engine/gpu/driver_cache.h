// Keeps and checks the shader caches of drivers, because Mesa 22.3 never replaces a damaged entry.
#pragma once

#include <vulkan/vulkan.h>

#include <filesystem>

namespace typodont::gpu {

/// Sets the folder for pipelines and for Mesa's cache, unless the user set another. Call once, before any device or
/// thread is created. Without this call, drivers use their own folders.
void keep_driver_cache(const std::filesystem::path& folder);

/// Removes cached files that changed since list_driver_cache() stored their hashes. Call once, before a driver is
/// loaded.
void check_driver_cache();
/// Opens the stored pipelines, or an empty cache if there are none. Returns null if no folder is set.
VkPipelineCache open_pipelines(VkDevice device, const VkPhysicalDeviceProperties& properties);
/// Stores the pipelines and destroys the cache object.
void close_pipelines(VkDevice device, const VkPhysicalDeviceProperties& properties, VkPipelineCache pipelines);
/// Lists all files with their hashes. Call after the drivers' last write.
void list_driver_cache();

}  // namespace typodont::gpu
