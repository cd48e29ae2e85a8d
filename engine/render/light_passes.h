// The light's rays and random walks as compute passes on a graphics card: inside tissue (shaders/tissue_gather.comp,
// tissue_walk.comp) and between bodies (shaders/body_rays.comp).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "engine/base/log.h"
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

/// Shared by one TissueLight and one LightScene, in one thread at a time. memory(), trace() and cast() are called
/// inside attempt(), because they throw DeviceLost or RunFailure if the card fails.
class LightPasses {
 public:
  /// Creates passes with a Vulkan device of their own, of the graphics card with this name. Null: Vulkan fails
  /// (logged).
  static std::unique_ptr<LightPasses> make(const std::string& card);
  /// Takes over the device.
  explicit LightPasses(gpu::Device device);
  ~LightPasses();
  LightPasses(const LightPasses&) = delete;
  LightPasses& operator=(const LightPasses&) = delete;

  /// Calls work(*this). Returns false if this or an earlier call failed (logged); then the CPU must do the work.
  template <class Work>
  bool attempt(const Work& work) {
    if (failed_) return false;
    try {
      work(*this);
    } catch (const std::exception& e) {
      log::warn("the GPU's passes for light failed; the CPU continues: {}", e.what());
      failed_ = true;
    }
    return !failed_;
  }
  bool failed() const { return failed_; }

  // Bindings of the shaders, and types of their values.
  template <class T>
  struct Binding {
    std::uint32_t number;
  };
  static constexpr Binding<float> kDistances{0};
  static constexpr Binding<std::uint32_t> kCells{1};  // 2 × (element + 1) + 1 in a hard body
  static constexpr Binding<std::uint32_t> kBlocks{2};
  static constexpr Binding<shared::LightElement> kElements{3};
  static constexpr Binding<glm::vec4> kSteps{4}, kFaces{5};
  static constexpr Binding<glm::vec3> kImages{6};
  static constexpr Binding<shared::RayNode> kNodes{8};
  static constexpr Binding<shared::RaySurface> kSurfaces{9};
  /// Returns memory for `count` values, which the caller fills before trace() or cast(). If it grows, its content is
  /// lost.
  template <class T>
  std::span<T> memory(Binding<T> binding, std::size_t count) {
    return {reinterpret_cast<T*>(memory(binding.number, count * sizeof(T))), count};
  }

  /// Casts the rays of the elements `gathered`, follows the walks of the elements `walked`, and waits for the results.
  /// Throws Stopped (engine/base/in_parallel.h) after a request to `stop`.
  void trace(shared::LightPass pass, std::span<const std::int32_t> gathered, std::span<const std::int32_t> walked,
             TracedLight& found, const std::stop_token& stop);
  /// Casts a ray between bodies from each start (m, frame W) in each direction, and waits for the results. `hits`: for
  /// each start, the rays in the order of their directions. `any`: as in body_rays.h. Throws Stopped after a request to
  /// `stop`.
  void cast(std::span<const glm::vec3> starts, std::span<const glm::vec3> directions, bool any,
            std::span<shared::RayHit> hits, const std::stop_token& stop);

 private:
  static constexpr Binding<std::int32_t> kListed{7};
  static constexpr Binding<glm::vec4> kStarts{10}, kDirections{11};
  static constexpr std::uint32_t kFirstResult = 12;
  static constexpr Binding<shared::LightArrival> kArrivals{kFirstResult};
  static constexpr Binding<std::int32_t> kMet{13};
  static constexpr Binding<glm::ivec2> kExits{14};
  static constexpr Binding<shared::RayHit> kHits{15};
  static constexpr std::size_t kBindings = 16;

  void destroy() noexcept;
  std::byte* memory(std::uint32_t binding, std::size_t bytes);
  template <class Pass>
  void run(VkPipeline pipeline, const Pass& pass, std::size_t threads);

  gpu::Device device_;
  gpu::ShaderInputs inputs_;
  VkPipeline gather_ = VK_NULL_HANDLE, walk_ = VK_NULL_HANDLE, cast_ = VK_NULL_HANDLE;
  std::array<gpu::Buffer, kBindings> buffers_{};
  bool failed_ = false;
};

}  // namespace typodont::render
