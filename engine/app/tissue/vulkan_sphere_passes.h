// The three GPU passes of the model "packing" as compute shaders (shaders/sphere_*.comp).
#pragma once

#include <cstddef>
#include <memory>

#include "engine/gpu/device.h"
#include "haptics/sphere_passes.h"

namespace typodont {

/// The factory of haptics/sphere_passes.h. Null if no device has double precision and enough memory; a CPU device only
/// with `any_device`.
std::unique_ptr<haptics::SpherePasses> make_vulkan_sphere_passes(std::size_t spheres, bool any_device);
/// Owns the device, which needs DeviceOptions::doubles. Throws RunFailure.
std::unique_ptr<haptics::SpherePasses> vulkan_sphere_passes(const gpu::Device& device, std::size_t spheres);

}  // namespace typodont
