#include "engine/render/particle_cloud.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "engine/base/units.h"
#include "shaders/debris_comp.h"

namespace typodont::render {

namespace {

struct Step {  // layout as in debris.comp
  glm::vec4 gravity, origin;
  glm::ivec4 size;
  glm::vec4 sink, air, bounce;
  glm::uvec4 ring;
};
static_assert(sizeof(Step) <= 128);

constexpr std::size_t kInstance = 20;  // bytes, size of a particle's instance; layout as in particle_pass.cpp

}  // namespace

ParticleCloud::ParticleCloud(gpu::Device& device, const CloudLaw& law, std::vector<float> distance)
    : device_(device), law_(law), distance_(std::move(distance)) {}

ParticleCloud::~ParticleCloud() {
  vkDeviceWaitIdle(device_.device);
  if (!pipeline_) return;
  vkDestroyPipeline(device_.device, pipeline_, nullptr);
  inputs_.destroy(device_);
  for (gpu::Buffer* b : {&particles_, &instances_, &field_}) b->destroy(device_);
  for (gpu::Buffer& b : staging_)
    if (b.buffer) b.destroy(device_);
}

void ParticleCloud::create() {
  const VkShaderStageFlags compute = VK_SHADER_STAGE_COMPUTE_BIT;
  const gpu::ShaderInputs::Binding buffer{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, compute};
  inputs_ = gpu::ShaderInputs::create(device_, {buffer, buffer, buffer}, 1, sizeof(Step));
  pipeline_ = gpu::create_compute_pipeline(device_, kSpirv_debris_comp, inputs_.layout);
  particles_ = gpu::Buffer::create(
      device_, law_.capacity * sizeof(CloudParticle),
      VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
  instances_ = gpu::Buffer::create(device_, law_.capacity * kInstance,
                                   VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  field_ = gpu::Buffer::create(device_, std::max<std::size_t>(distance_.size(), 1) * sizeof(float),
                               VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
  if (!distance_.empty()) std::memcpy(field_.memory.mapped, distance_.data(), distance_.size() * sizeof(float));
  inputs_.fill(device_, 0, 0, particles_);
  inputs_.fill(device_, 0, 1, instances_);
  inputs_.fill(device_, 0, 2, field_);
}

std::size_t ParticleCloud::add(std::span<const CloudParticle> born) {
  const std::size_t taken = std::min(born.size(), room());
  if (taken == 0) return 0;
  born_.insert(born_.end(), born.begin(), born.begin() + static_cast<std::ptrdiff_t>(taken));
  if (cohorts_.empty() || cohorts_.back().born_at != time_) cohorts_.push_back({time_, 0});
  cohorts_.back().count += taken;
  count_ += taken;
  return taken;
}

void ParticleCloud::suck(const glm::dvec3& p_W, double flow, double radius) {
  sink_ = glm::vec4(glm::dvec4(p_W, flow / (4 * kPi)));
  nozzle_ = radius;
}

void ParticleCloud::advance(double dt) {
  time_ += dt;
  if (count_ > 0 || shown_ > 0) pending_ += dt;
  // Removes particles at the end of their lifetime, but not before they have reached the GPU.
  while (!cohorts_.empty() && time_ - cohorts_.front().born_at >= law_.lifetime &&
         count_ - cohorts_.front().count >= born_.size()) {
    first_ = (first_ + cohorts_.front().count) % law_.capacity;
    count_ -= cohorts_.front().count;
    cohorts_.pop_front();
  }
}

std::vector<ParticleCloud::Run> ParticleCloud::runs() const {
  if (shown_ == 0) return {};
  const std::size_t end = std::min(first_ + shown_, law_.capacity);
  std::vector<Run> out{{static_cast<std::uint32_t>(first_), static_cast<std::uint32_t>(end - first_)}};
  if (first_ + shown_ > end) out.push_back({0, static_cast<std::uint32_t>(first_ + shown_ - end)});
  return out;
}

void ParticleCloud::record(VkCommandBuffer commands, int slot) {
  const double dt = std::exchange(pending_, 0.0);
  shown_ = count_;
  if (count_ == 0) return;
  if (!pipeline_) create();
  constexpr VkPipelineStageFlags2 kCompute = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
                                  kCopy = VK_PIPELINE_STAGE_2_COPY_BIT;
  constexpr VkAccessFlags2 kReadWrite = VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;
  if (!born_.empty()) {
    gpu::Buffer& staging = staging_[static_cast<std::size_t>(slot)];
    const std::size_t bytes = born_.size() * sizeof(CloudParticle);
    if (staging.size < bytes) {
      if (staging.buffer) staging.destroy(device_);
      staging = gpu::Buffer::create(device_, 2 * bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    }
    std::memcpy(staging.memory.mapped, born_.data(), bytes);
    const std::size_t at = (first_ + count_ - born_.size()) % law_.capacity;
    const std::size_t before_end = std::min(born_.size(), law_.capacity - at);
    std::vector<VkBufferCopy> parts{{0, at * sizeof(CloudParticle), before_end * sizeof(CloudParticle)}};
    if (before_end < born_.size())
      parts.push_back({before_end * sizeof(CloudParticle), 0, (born_.size() - before_end) * sizeof(CloudParticle)});
    gpu::memory_barrier(commands, kCompute, kReadWrite, kCopy, VK_ACCESS_2_TRANSFER_WRITE_BIT);
    vkCmdCopyBuffer(commands, staging.buffer, particles_.buffer, static_cast<std::uint32_t>(parts.size()),
                    parts.data());
    born_.clear();
  }
  gpu::memory_barrier(commands, kCopy | kCompute | VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT,
                      VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, kCompute, kReadWrite);
  const Step step{glm::vec4(glm::dvec4(law_.gravity, dt)),
                  glm::vec4(glm::dvec4(law_.origin, law_.spacing)),
                  glm::ivec4(law_.size, static_cast<int>(law_.capacity)),
                  sink_,
                  glm::vec4(glm::dvec4(law_.air_density, law_.air_viscosity, nozzle_, law_.decay_time)),
                  glm::vec4(glm::dvec4(law_.restitution, law_.slide, law_.min_shown, law_.lifetime)),
                  glm::uvec4(first_, count_, 0, 0)};
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_);
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, inputs_.layout, 0, 1, &inputs_.sets[0], 0, nullptr);
  vkCmdPushConstants(commands, inputs_.layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof step, &step);
  ++steps_;
  vkCmdDispatch(commands, static_cast<std::uint32_t>((count_ + 63) / 64), 1, 1);
  gpu::memory_barrier(commands, kCompute, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, VK_PIPELINE_STAGE_2_VERTEX_INPUT_BIT,
                      VK_ACCESS_2_VERTEX_ATTRIBUTE_READ_BIT);
}

std::vector<CloudParticle> ParticleCloud::read() {
  std::vector<CloudParticle> out;
  if (!pipeline_) return out;
  gpu::Buffer all = gpu::Buffer::create_readback(device_, law_.capacity * sizeof(CloudParticle));
  gpu::run_once(device_, [&](VkCommandBuffer commands) {
    gpu::memory_barrier(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT,
                        VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT);
    const VkBufferCopy whole{0, 0, law_.capacity * sizeof(CloudParticle)};
    vkCmdCopyBuffer(commands, particles_.buffer, all.buffer, 1, &whole);
    gpu::memory_barrier(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                        VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
  });
  for (std::size_t i = 0; i < shown_; ++i) out.push_back(all.mapped<CloudParticle>()[(first_ + i) % law_.capacity]);
  all.destroy(device_);
  return out;
}

}  // namespace typodont::render
