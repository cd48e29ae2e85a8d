#include "engine/render/light_passes.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <utility>

#include "engine/base/in_parallel.h"
#include "engine/base/log.h"
#include "shaders/body_rays_comp.h"
#include "shaders/tissue_gather_comp.h"
#include "shaders/tissue_walk_comp.h"

namespace typodont::render {

namespace {

constexpr std::size_t kGroup = 64;  // number of threads in a workgroup, as in the shaders
// Most rays or walks of one submission, so that a slow device ends each one in time.
constexpr std::size_t kAtOnce = std::size_t{1} << 21;

}  // namespace

std::unique_ptr<LightPasses> LightPasses::make(const std::string& card) {
  try {
    gpu::DeviceOptions options;
    options.prefer = card;
    return std::make_unique<LightPasses>(gpu::Device::create(options));
  } catch (const std::exception& e) {
    log::warn("no GPU for the light; the CPU computes it: {}", e.what());
    return nullptr;
  }
}

LightPasses::LightPasses(gpu::Device device) : device_(std::move(device)) {
  try {
    const gpu::ShaderInputs::Binding buffer{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_SHADER_STAGE_COMPUTE_BIT};
    inputs_ = gpu::ShaderInputs::create(device_, std::vector(kBindings, buffer), 1, sizeof(shared::LightPass));
    gather_ = gpu::create_compute_pipeline(device_, kSpirv_tissue_gather_comp, inputs_.layout);
    walk_ = gpu::create_compute_pipeline(device_, kSpirv_tissue_walk_comp, inputs_.layout);
    cast_ = gpu::create_compute_pipeline(device_, kSpirv_body_rays_comp, inputs_.layout);
  } catch (...) {
    destroy();
    throw;
  }
}

LightPasses::~LightPasses() {
  destroy();
}

void LightPasses::destroy() noexcept {
  vkDeviceWaitIdle(device_.device);
  for (const VkPipeline pipeline : {gather_, walk_, cast_})
    if (pipeline) vkDestroyPipeline(device_.device, pipeline, nullptr);
  if (inputs_.layout) inputs_.destroy(device_);
  for (gpu::Buffer& b : buffers_)
    if (b.buffer) b.destroy(device_);
  device_.destroy();
}

/// Returns a buffer's memory. Replaces a buffer that is too small.
std::byte* LightPasses::memory(std::uint32_t binding, std::size_t bytes) {
  gpu::Buffer& buffer = buffers_[binding];
  bytes = std::max<std::size_t>(bytes, 1);
  if (buffer.size < bytes) {
    if (buffer.buffer) buffer.destroy(device_);
    constexpr VkBufferUsageFlags kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    buffer = binding >= kFirstResult ? gpu::Buffer::create_readback(device_, bytes, kStorage)
                                     : gpu::Buffer::create(device_, bytes, kStorage);
    inputs_.fill(device_, 0, binding, buffer);
  }
  return buffer.mapped<std::byte>();
}

template <class Pass>
void LightPasses::run(VkPipeline pipeline, const Pass& pass, std::size_t threads) {
  gpu::run_once(device_, [&](VkCommandBuffer commands) {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, inputs_.layout, 0, 1, &inputs_.sets[0], 0,
                            nullptr);
    vkCmdPushConstants(commands, inputs_.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof pass, &pass);
    vkCmdDispatch(commands, static_cast<std::uint32_t>((threads + kGroup - 1) / kGroup), 1, 1);
    gpu::make_visible_to_host(commands, VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT);
  });
}

void LightPasses::trace(shared::LightPass pass, std::span<const std::int32_t> gathered,
                        std::span<const std::int32_t> walked, TracedLight& found, const std::stop_token& stop) {
  constexpr auto kRays = static_cast<std::size_t>(shared::kSurfaceRays);
  const auto walks = static_cast<std::size_t>(pass.size.w);
  found.arrivals.resize(gathered.size());
  found.met.resize(gathered.size() * kRays);
  found.exits.resize(walked.size() * walks);
  const auto parts = [&](std::span<const std::int32_t> list, std::size_t threads_each, const auto& part) {
    const std::size_t most = kAtOnce / threads_each;
    for (std::size_t first = 0; first < list.size(); first += most) {
      if (stop.stop_requested()) throw Stopped();
      const std::size_t count = std::min(most, list.size() - first);
      std::memcpy(memory(kListed, count).data(), &list[first], count * sizeof(std::int32_t));
      pass.blocks.w = static_cast<int>(count);
      part(first, count);
    }
  };
  // Every binding of tissue_rays.glsl needs a buffer, also those that only the other shader uses.
  const std::size_t rays = std::min(gathered.size(), kAtOnce / kRays);
  const std::span arrivals = memory(kArrivals, rays);
  const std::span met = memory(kMet, rays * kRays);
  const std::span exits = memory(kExits, std::min(walked.size(), kAtOnce / walks) * walks);
  parts(gathered, kRays, [&](std::size_t first, std::size_t count) {
    run(gather_, pass, count);
    std::memcpy(&found.arrivals[first], arrivals.data(), count * sizeof(shared::LightArrival));
    std::memcpy(&found.met[first * kRays], met.data(), count * kRays * sizeof(std::int32_t));
  });
  parts(walked, walks, [&](std::size_t first, std::size_t count) {
    run(walk_, pass, count * walks);
    std::memcpy(&found.exits[first * walks], exits.data(), count * walks * sizeof(glm::ivec2));
  });
}

void LightPasses::cast(std::span<const glm::vec3> starts, std::span<const glm::vec3> directions, bool any,
                       std::span<shared::RayHit> hits, const std::stop_token& stop) {
  std::ranges::transform(directions, memory(kDirections, directions.size()).begin(),
                         [](const glm::vec3& d) { return glm::vec4(d, 0); });
  const std::size_t most = std::min(starts.size(), kAtOnce / directions.size());
  const std::span from = memory(kStarts, most);
  const std::span found = memory(kHits, most * directions.size());
  for (std::size_t first = 0; first < starts.size(); first += most) {
    if (stop.stop_requested()) throw Stopped();
    const std::size_t count = std::min(most, starts.size() - first);
    std::ranges::transform(starts.subspan(first, count), from.begin(),
                           [](const glm::vec3& p) { return glm::vec4(p, 0); });
    run(cast_, shared::RayPass{static_cast<int>(count), static_cast<int>(directions.size()), any},
        count * directions.size());
    std::ranges::copy(found.first(count * directions.size()), &hits[first * directions.size()]);
  }
}

}  // namespace typodont::render
