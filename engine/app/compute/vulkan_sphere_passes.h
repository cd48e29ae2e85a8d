// The three passes of the model "packing" as Vulkan compute (shaders/sphere_*.comp).
#pragma once

#include <cstddef>
#include <memory>

#include "engine/gpu/device.h"
#include "haptics/sphere_passes.h"

namespace typodont {

/// The maker that haptics/sphere_passes.h asks for. Makes a Vulkan device of its own, which only the returned passes
/// use. Null without a device that computes in doubles or has the memory; a processor only where `any_device`.
std::unique_ptr<haptics::SpherePasses> make_vulkan_sphere_passes(std::size_t spheres, bool any_device);
/// The same on a device made with DeviceOptions::doubles, which they destroy. Throws RunFailure.
std::unique_ptr<haptics::SpherePasses> vulkan_sphere_passes(const gpu::Device& device, std::size_t spheres);

}  // namespace typodont
