// Drivers' shader caches, kept and checked: Mesa 22.3 never replaces a damaged entry.
#pragma once

#include <vulkan/vulkan.h>

#include <filesystem>

namespace typodont::gpu {

/// Folder of pipelines, and of Mesa's cache unless the user set another. Once, before any device or thread. Without it,
/// drivers use their own.
void keep_driver_cache(const std::filesystem::path& folder);

/// Removes changed files. Once, before a driver is loaded.
void check_driver_cache();
/// Empty if none are stored; null without a folder.
VkPipelineCache open_pipelines(VkDevice device, const VkPhysicalDeviceProperties& properties);
/// Stores the pipelines and destroys the cache object.
void close_pipelines(VkDevice device, const VkPhysicalDeviceProperties& properties, VkPipelineCache pipelines);
/// After the drivers' last write.
void list_driver_cache();

}  // namespace typodont::gpu
