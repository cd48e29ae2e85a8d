// Particles that live on the GPU: moved by compute in the frame that draws them, by the law of engine/debris. None
// alive: no memory, no pipeline, no work. Render thread.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

#include "engine/gpu/device.h"
#include "engine/gpu/resources.h"

namespace typodont::render {

/// What moves them: as debris::DebrisOptions and debris::CoarseField say.
struct CloudLaw {
  std::size_t capacity = 100'000;
  glm::dvec3 gravity{0, 0, -9.81};                   // m/s²
  double air_density = 1.2, air_viscosity = 1.8e-5;  // kg/m³, Pa·s
  double restitution = 0.3, slide = 0.7;             // of the speed along the normal, across it
  double decay_time = 2, lifetime = 6;               // s
  double least_shown = 3e-5;                         // m: smaller ones are drawn this large, and fainter
  glm::dvec3 origin{0};                              // of the field, m, W
  double spacing = 5e-4;                             // m
  glm::ivec3 size{0};                                // samples, x slowest; none: nothing to bounce off
};

struct CloudParticle {
  glm::vec3 p{0};                              // m, W
  float age = 0;                               // s
  glm::vec3 v{0};                              // m/s
  float mass = 0;                              // kg, at birth; 0: sucked away
  float chip = 0;                              // m, diameter of its single chips
  float density = 0;                           // kg/m³
  float rate = -1;                             // 1/s, of drag; ≥ 1e30: at rest, < 0: by its speed
  std::uint8_t color[4] = {255, 255, 255, 0};  // sRGB
};
static_assert(sizeof(CloudParticle) == 48);

class ParticleCloud {
 public:
  /// `distance`: m, of the field.
  ParticleCloud(gpu::Device& device, const CloudLaw& law, std::vector<float> distance);
  ~ParticleCloud();
  ParticleCloud(const ParticleCloud&) = delete;
  ParticleCloud& operator=(const ParticleCloud&) = delete;

  /// From the next step on; what finds no room is not taken. Returns how many were.
  std::size_t add(std::span<const CloudParticle> born);
  /// A nozzle that draws air in: flow in m³/s, 0: switched off.
  void suck(const glm::dvec3& p_W, double flow, double radius);
  /// Time goes on, s: done when the next frame is recorded.
  void advance(double dt);
  std::size_t alive() const { return count_; }
  std::size_t room() const { return law_.capacity - count_; }
  /// Something moves, or is gone, with the next record().
  bool changes() const { return pending_ > 0 && (count_ > 0 || shown_ > 0); }

  /// What was asked for since the last record(), as compute commands; before the pass that draws.
  void record(VkCommandBuffer commands, int slot);
  /// What the last record() left to draw: instances as ParticlePass has them, in one or two runs.
  VkBuffer instances() const { return instances_.buffer; }
  struct Run {
    std::uint32_t first = 0, count = 0;
  };
  std::vector<Run> runs() const;
  int pipelines() const { return pipeline_ ? 1 : 0; }
  int steps() const { return steps_; }  // dispatched so far
  /// For tests: waits, and reads the living back, oldest first.
  std::vector<CloudParticle> read();

 private:
  void create();

  gpu::Device& device_;
  CloudLaw law_;
  std::vector<float> distance_;
  gpu::ShaderInputs inputs_;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
  gpu::Buffer particles_, instances_, field_;
  std::array<gpu::Buffer, gpu::FrameRing::kSlots> staging_;
  std::vector<CloudParticle> born_;  // since the last record
  struct Cohort {
    double born_at;  // s
    std::size_t count;
  };
  std::deque<Cohort> cohorts_;
  std::size_t first_ = 0, count_ = 0, shown_ = 0;
  double time_ = 0, pending_ = 0;  // s
  glm::vec4 sink_{0};
  double nozzle_ = 0;  // m
  int steps_ = 0;
};

}  // namespace typodont::render
