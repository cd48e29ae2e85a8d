// The three GPU passes of the contact model "packing", as compute shaders (shaders/sphere_*.comp).
#pragma once

#include <cstddef>
#include <memory>

#include "engine/gpu/device.h"
#include "haptics/sphere_passes.h"

namespace typodont {

/// Creates the passes (the factory of haptics/sphere_passes.h). Null if no device has double precision and enough
/// memory. A CPU device is used only with `any_device`.
std::unique_ptr<haptics::SpherePasses> make_vulkan_sphere_passes(std::size_t spheres, bool any_device);
/// Creates the passes on a device with DeviceOptions::doubles; the result owns it. Throws RunFailure.
std::unique_ptr<haptics::SpherePasses> vulkan_sphere_passes(const gpu::Device& device, std::size_t spheres);

}  // namespace typodont
