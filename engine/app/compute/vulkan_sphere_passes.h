// The three GPU passes of the contact model "packing", as Vulkan compute shaders (shaders/sphere_*.comp).
#pragma once

#include <cstddef>
#include <memory>

#include "engine/gpu/device.h"
#include "haptics/sphere_passes.h"

namespace typodont {

/// Implements the factory that haptics/sphere_passes.h declares. Creates a Vulkan device that only the returned passes
/// use. Returns null if no device supports double precision and has enough memory. A device that computes on the CPU is
/// used only if `any_device` is true.
std::unique_ptr<haptics::SpherePasses> make_vulkan_sphere_passes(std::size_t spheres, bool any_device);
/// Creates the passes on a GPU device that was created with DeviceOptions::doubles. The passes own the device and
/// destroy it. Throws RunFailure.
std::unique_ptr<haptics::SpherePasses> vulkan_sphere_passes(const gpu::Device& device, std::size_t spheres);

}  // namespace typodont
