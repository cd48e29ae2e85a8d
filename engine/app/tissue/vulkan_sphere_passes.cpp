#include "engine/app/tissue/vulkan_sphere_passes.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <glm/glm.hpp>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/log.h"
#include "engine/gpu/device.h"
#include "engine/gpu/resources.h"
#include "shaders/sphere_contact_comp.h"
#include "shaders/sphere_measure_comp.h"
#include "shaders/sphere_overlap_comp.h"
#include "shaders/sphere_removal_comp.h"

namespace typodont {

namespace {

using haptics::CuttingBall;
using haptics::FirstContact;
using haptics::RestingBall;
using haptics::SphereChange;
using haptics::SphereShare;
using haptics::SweptBall;
using haptics::packing::CutSphere;

constexpr std::size_t kGroup = 64;  // number of threads in a workgroup, as in the shaders
// Largest number of workgroups. With more spheres than threads, each thread processes several spheres.
constexpr std::size_t kMaxGroups = 1024;
constexpr std::size_t kMaxBalls = 2048;  // largest number of spheres of a tool
constexpr std::size_t kMinResults = 65536;
constexpr std::size_t kStagingBytes = std::size_t{16} << 20;
// Largest rounding error of a position, as a fraction of the tissue's extent: about a dozen roundings in single
// precision.
constexpr double kRounding = 2e-6;

// A sphere in the layout of shaders/spheres.glsl.
struct Ball {
  dvec3 a{0}, b{0}, near_to{0};
  double radius = 0, curve = 0;
};
static_assert(sizeof(Ball) == 88);
struct Pass {
  glm::vec4 around;
  double origin[3];
  float rounding_margin;
  std::uint32_t spheres, balls, capacity, printed;
};
static_assert(offsetof(Pass, rounding_margin) == 40 && offsetof(Pass, printed) == 56 && sizeof(Pass) <= 128);
struct Contact {
  double t;
  std::uint32_t ball, sphere;
};
/// Header of a list that a shader writes: `count` entries follow.
struct Head {
  std::uint32_t count, unused;
};
static_assert(sizeof(SphereShare) == 16 && sizeof(SphereChange) == 104);

enum PassKind { kContact, kOverlap, kMeasure, kRemoval, kKinds };

constexpr VkAccessFlags2 kShaderAccess = VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;

class VulkanSpherePasses final : public haptics::SpherePasses {
 public:
  VulkanSpherePasses(const gpu::Device& device, std::size_t spheres)
      : device_(device), count_(spheres), capacity_(std::max(kMinResults, spheres / 4)) {
    try {
      create();
    } catch (...) {
      destroy();
      throw;
    }
  }
  ~VulkanSpherePasses() override { destroy(); }
  VulkanSpherePasses(const VulkanSpherePasses&) = delete;
  VulkanSpherePasses& operator=(const VulkanSpherePasses&) = delete;

  std::string device() const override { return device_.name(); }
  std::size_t spheres() const noexcept override { return count_; }
  std::size_t max_balls() const noexcept override { return kMaxBalls; }

  bool load(std::span<const CutSphere> tissue, haptics::packing::Removal removal) noexcept override {
    if (tissue.size() != count_) return false;
    loaded_ = attempt([&] {
      dvec3 lo = tissue[0].base, hi = lo;
      for (const CutSphere& s : tissue)
        lo = glm::min(lo, s.base - s.base_radius), hi = glm::max(hi, s.base + s.base_radius);
      origin_ = 0.5 * (lo + hi);
      rounding_margin_ = kRounding * glm::length(hi - lo);
      printed_ = removal == haptics::packing::Removal::kAsPrinted;
      upload(spheres_, tissue.size(), sizeof(CutSphere),
             [&](std::size_t i, std::byte* to) { std::memcpy(to, &tissue[i], sizeof(CutSphere)); });
      upload(bounds_, tissue.size(), sizeof(glm::vec4), [&](std::size_t i, std::byte* to) {
        const double r = tissue[i].radius();
        const glm::vec4 bound(glm::vec3(tissue[i].center() - origin_),
                              r > 0 ? static_cast<float>(r + rounding_margin_) : -1.0f);
        std::memcpy(to, &bound, sizeof bound);
      });
    });
    return loaded_;
  }

  bool first_contact(std::span<const SweptBall> balls, FirstContact& first) noexcept override {
    first = {};
    if (!put(balls, [](const SweptBall& b) { return Ball{b.from, b.motion, b.from + b.motion, b.radius, 0}; }))
      return false;
    const std::size_t groups = run(kContact);
    if (groups == 0) return false;
    const auto* const found = results_.mapped<Contact>();
    Contact best{2, 0, 0};
    for (std::size_t g = 0; g < groups; ++g) {
      const Contact& c = found[g];
      if (c.t < best.t || (c.t == best.t && std::pair(c.ball, c.sphere) < std::pair(best.ball, best.sphere))) best = c;
    }
    if (best.t <= 1) first = {best.t, static_cast<int>(best.ball), static_cast<int>(best.sphere)};
    return true;
  }

  bool overlaps(std::span<const RestingBall> balls, std::span<const SphereShare>& found) noexcept override {
    return put(balls, [](const RestingBall& b) { return Ball{b.p, b.p, b.p, b.radius, 0}; }) && list(kOverlap, found);
  }

  bool measure_removal(std::span<const CuttingBall> balls, std::span<const SphereShare>& found) noexcept override {
    return put_cutting(balls) && list(kMeasure, found);
  }

  bool remove(std::span<const CuttingBall> balls, std::span<const SphereChange>& found) noexcept override {
    return put_cutting(balls) && list(kRemoval, found);
  }

 private:
  void create() {
    const gpu::ShaderInputs::Binding buffer{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_SHADER_STAGE_COMPUTE_BIT};
    inputs_ = gpu::ShaderInputs::create(device_, {buffer, buffer, buffer, buffer}, 1, sizeof(Pass));
    const std::span<const std::uint32_t> shaders[kKinds] = {kSpirv_sphere_contact_comp, kSpirv_sphere_overlap_comp,
                                                            kSpirv_sphere_measure_comp, kSpirv_sphere_removal_comp};
    for (std::size_t k = 0; k < kKinds; ++k) {
      pipelines_[k] = gpu::create_compute_pipeline(device_, shaders[k], inputs_.layout);
    }
    constexpr VkBufferUsageFlags kFilled = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    spheres_ = gpu::Buffer::create_local(device_, count_ * sizeof(CutSphere), kFilled);
    bounds_ = gpu::Buffer::create_local(device_, count_ * sizeof(glm::vec4), kFilled);
    balls_ = gpu::Buffer::create(device_, kMaxBalls * sizeof(Ball), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    results_ = gpu::Buffer::create_readback(
        device_, std::max(sizeof(Head) + capacity_ * sizeof(SphereChange), kMaxGroups * sizeof(Contact)),
        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    staging_ = gpu::Buffer::create(device_, kStagingBytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    std::uint32_t binding = 0;
    for (const gpu::Buffer* b : {&spheres_, &bounds_, &balls_, &results_}) inputs_.fill(device_, 0, binding++, *b);

    const VkCommandPoolCreateInfo pool{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                       .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                       .queueFamilyIndex = device_.queue_family};
    gpu::check(vkCreateCommandPool(device_.device, &pool, nullptr, &pool_), "vkCreateCommandPool");
    const VkCommandBufferAllocateInfo allocate{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                               .commandPool = pool_,
                                               .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                               .commandBufferCount = 1};
    gpu::check(vkAllocateCommandBuffers(device_.device, &allocate, &commands_), "vkAllocateCommandBuffers");
    const VkFenceCreateInfo fence{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    gpu::check(vkCreateFence(device_.device, &fence, nullptr, &done_), "vkCreateFence");
  }

  void destroy() noexcept {
    if (!device_.device) return;
    vkDeviceWaitIdle(device_.device);
    if (done_) vkDestroyFence(device_.device, done_, nullptr);
    if (pool_) vkDestroyCommandPool(device_.device, pool_, nullptr);
    for (const VkPipeline pipeline : pipelines_) {
      if (pipeline) vkDestroyPipeline(device_.device, pipeline, nullptr);
    }
    if (inputs_.layout) inputs_.destroy(device_);
    for (gpu::Buffer* b : {&spheres_, &bounds_, &balls_, &results_, &staging_}) {
      if (b->buffer) b->destroy(device_);
    }
    device_.destroy();
  }

  /// Runs `work`. Returns false, and logs, if Vulkan fails.
  template <class F>
  bool attempt(F&& work) noexcept {
    try {
      work();
      return true;
    } catch (const std::exception& e) {
      log::warn("the GPU's passes over spheres failed; the CPU continues: {}", e.what());
      loaded_ = false;
      return false;
    }
  }

  /// Uploads an array in pieces. For set-up only.
  template <class Write>
  void upload(const gpu::Buffer& to, std::size_t count, std::size_t bytes, Write&& write) {
    const std::size_t at_once = kStagingBytes / bytes;
    for (std::size_t first = 0; first < count; first += at_once) {
      const std::size_t n = std::min(at_once, count - first);
      for (std::size_t i = 0; i < n; ++i) write(first + i, staging_.memory.mapped + i * bytes);
      gpu::run_once(device_, [&](VkCommandBuffer commands) {
        const VkBufferCopy part{0, first * bytes, n * bytes};
        vkCmdCopyBuffer(commands, staging_.buffer, to.buffer, 1, &part);
        gpu::memory_barrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                            VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, kShaderAccess);
      });
    }
  }

  /// Uploads the tool's spheres, and a sphere around their whole motion.
  template <class From, class Make>
  bool put(std::span<const From> from, Make&& make) noexcept {
    if (!loaded_ || from.empty() || from.size() > kMaxBalls) return false;
    auto* const to = balls_.mapped<Ball>();
    balls_put_ = static_cast<std::uint32_t>(from.size());
    dvec3 lo(1e300), hi(-1e300);
    for (std::size_t i = 0; i < from.size(); ++i) {
      const Ball ball = make(from[i]);
      std::memcpy(to + i, &ball, sizeof ball);
      lo = glm::min(lo, glm::min(ball.a, ball.near_to) - ball.radius);
      hi = glm::max(hi, glm::max(ball.a, ball.near_to) + ball.radius);
    }
    const dvec3 middle = 0.5 * (lo + hi) - origin_;
    double reach = 0;
    for (std::size_t i = 0; i < from.size(); ++i) {
      const Ball ball = make(from[i]);
      reach = std::max({reach, glm::distance(ball.a - origin_, middle) + ball.radius,
                        glm::distance(ball.near_to - origin_, middle) + ball.radius});
    }
    // Adds the rounding errors of single-precision positions and distances.
    reach += rounding_margin_ + kRounding * (glm::length(middle) + reach);
    around_ = glm::vec4(glm::vec3(middle), static_cast<float>(reach));
    return true;
  }
  bool put_cutting(std::span<const CuttingBall> balls) noexcept {
    return put(balls, [](const CuttingBall& b) { return Ball{b.from, b.to, b.near_to, b.radius, b.curve}; });
  }

  /// Runs one pass and waits for its end. Returns the number of workgroups; 0: failed.
  std::size_t run(PassKind kind) noexcept {
    const std::size_t groups = std::clamp<std::size_t>((count_ + kGroup - 1) / kGroup, 1, kMaxGroups);
    const Pass pass{around_,
                    {origin_.x, origin_.y, origin_.z},
                    static_cast<float>(rounding_margin_),
                    static_cast<std::uint32_t>(count_),
                    balls_put_,
                    static_cast<std::uint32_t>(capacity_),
                    printed_ ? 1u : 0u};
    const bool ran = attempt([&] {
      const VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                           .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
      gpu::check(vkBeginCommandBuffer(commands_, &begin), "vkBeginCommandBuffer");
      vkCmdBindPipeline(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_[kind]);
      vkCmdBindDescriptorSets(commands_, VK_PIPELINE_BIND_POINT_COMPUTE, inputs_.layout, 0, 1, &inputs_.sets[0], 0,
                              nullptr);
      vkCmdPushConstants(commands_, inputs_.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof pass, &pass);
      vkCmdDispatch(commands_, static_cast<std::uint32_t>(groups), 1, 1);
      // Makes the results of this pass visible to the next pass and to the CPU.
      gpu::memory_barrier(commands_, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT,
                          VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_HOST_BIT,
                          kShaderAccess | VK_ACCESS_2_HOST_READ_BIT);
      gpu::check(vkEndCommandBuffer(commands_), "vkEndCommandBuffer");
      const VkSubmitInfo submit{
          .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands_};
      gpu::check(vkQueueSubmit(device_.queue, 1, &submit, done_), "vkQueueSubmit");
      gpu::check(vkWaitForFences(device_.device, 1, &done_, VK_TRUE, UINT64_MAX), "vkWaitForFences");
      gpu::check(vkResetFences(device_.device, 1, &done_), "vkResetFences");
    });
    return ran ? groups : 0;
  }

  template <class Result>
  bool list(PassKind kind, std::span<const Result>& found) noexcept {
    auto* const head = results_.mapped<Head>();
    head->count = 0;
    if (run(kind) == 0) return false;
    if (head->count > capacity_) {
      // The list was too short, so some results were not stored. The tissue must be loaded again.
      loaded_ = false;
      return false;
    }
    found = {results_.mapped<Result>(sizeof(Head)), head->count};
    return true;
  }

  gpu::Device device_;
  std::size_t count_, capacity_;
  gpu::ShaderInputs inputs_;
  VkPipeline pipelines_[kKinds] = {};
  gpu::Buffer spheres_, bounds_, balls_, results_, staging_;
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence done_ = VK_NULL_HANDLE;
  bool loaded_ = false, printed_ = false;
  dvec3 origin_{0};             // m, frame W: origin of the positions in single precision
  double rounding_margin_ = 0;  // m, rounding error of a position
  std::uint32_t balls_put_ = 0;
  glm::vec4 around_{0};
};

}  // namespace

std::unique_ptr<haptics::SpherePasses> vulkan_sphere_passes(const gpu::Device& device, std::size_t spheres) {
  return std::make_unique<VulkanSpherePasses>(device, spheres);
}

std::unique_ptr<haptics::SpherePasses> make_vulkan_sphere_passes(std::size_t spheres, bool any_device) {
  const std::vector<gpu::DeviceInfo> devices = gpu::list_devices();
  if (spheres == 0 || devices.empty() || (devices.front().processor && !any_device)) return nullptr;
  try {
    gpu::DeviceOptions options;
    options.doubles = true;
    return vulkan_sphere_passes(gpu::Device::create(options), spheres);
  } catch (const std::exception& e) {
    log::warn("no GPU for passes over spheres: {}", e.what());
    return nullptr;
  }
}

}  // namespace typodont
