// Stores the drivers' shader caches in a folder of this program between runs. The files are checked before a driver
// reads them, because Mesa (22.3) rejects a damaged entry, recompiles it at every start and never replaces it.
#pragma once

#include <vulkan/vulkan.h>

#include <filesystem>

namespace typodont::gpu {

/// Sets the folder in which this program's devices store their pipelines. If the cache folder of a driver can be
/// configured (Mesa), the driver uses the same folder for its own cache, unless the user has configured another folder.
/// Call once, before any device and any other thread exists. Without this call, each driver uses its default folder.
void keep_driver_cache(const std::filesystem::path& folder);

/// Removes the files that changed since they were stored. Call once per process, before a driver is loaded.
void check_driver_cache();
/// Opens the device's stored pipelines, or an empty cache if none are stored. Returns null if no folder is set.
VkPipelineCache open_pipelines(VkDevice device, const VkPhysicalDeviceProperties& properties);
/// Stores the pipelines and destroys the cache object.
void close_pipelines(VkDevice device, const VkPhysicalDeviceProperties& properties, VkPipelineCache pipelines);
/// Writes the list with the hashes of all files in the folder. Call after the drivers' last write.
void list_driver_cache();

}  // namespace typodont::gpu
