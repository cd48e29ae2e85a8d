// Rays and random walks of the light inside tissue as compute passes (shaders/tissue_gather.comp, tissue_walk.comp).
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "engine/gpu/device.h"
#include "engine/gpu/resources.h"
#include "engine/render/shared.h"

namespace typodont::render {

/// Results of the rays and walks from a list of elements.
struct TracedLight {
  std::vector<shared::LightArrival> arrivals;
  std::vector<std::int32_t> met;  // kSurfaceRays per element: index of the element that the ray meets, kFree or kNone
  std::vector<glm::ivec2> exits;  // per walk: element where it ends or kNone; packed weight (tissue_rays.h)
};

/// Used by one thread at a time. Any call may throw DeviceLost or RunFailure; then the object is of no more use.
class LightPasses {
 public:
  /// Creates passes with a Vulkan device of their own, of the graphics card with this name. Null: Vulkan fails
  /// (logged).
  static std::unique_ptr<LightPasses> make(const std::string& card);
  /// Takes over the device.
  explicit LightPasses(const gpu::Device& device);
  ~LightPasses();
  LightPasses(const LightPasses&) = delete;
  LightPasses& operator=(const LightPasses&) = delete;

  /// Memory that the caller fills before trace(). If it grows, its content is lost.
  std::span<float> distances(std::size_t cells);
  std::span<std::uint32_t> cells(std::size_t count);  // 2 × (element + 1) + 1 in a hard body
  std::span<std::uint32_t> blocks(std::size_t count);
  std::span<shared::LightElement> elements(std::size_t count);
  std::span<glm::vec4> steps(std::size_t count);
  std::span<glm::vec4> faces(std::size_t count);
  std::span<glm::vec3> images(std::size_t count);

  /// Casts the rays of the elements `gathered`, follows the walks of the elements `walked`, and waits for the results.
  /// Throws Stopped (engine/base/in_parallel.h) after a request to `stop`.
  void trace(shared::LightPass pass, std::span<const std::int32_t> gathered, std::span<const std::int32_t> walked,
             TracedLight& found, const std::stop_token& stop);

 private:
  // Bindings of the shaders.
  enum Binding { kDistances, kCells, kBlocks, kElements, kSteps, kFaces, kImages, kListed, kArrivals, kMet, kExits };
  static constexpr std::size_t kBindings = kExits + 1;

  void destroy() noexcept;
  template <class T>
  std::span<T> memory(Binding binding, std::size_t count);
  void run(VkPipeline pipeline, const shared::LightPass& pass, std::size_t threads);

  gpu::Device device_;
  gpu::ShaderInputs inputs_;
  VkPipeline gather_ = VK_NULL_HANDLE, walk_ = VK_NULL_HANDLE;
  std::array<gpu::Buffer, kBindings> buffers_{};
};

}  // namespace typodont::render
