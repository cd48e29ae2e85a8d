// Particles that are stored on the GPU. Before each frame, compute shaders move the particles, by the same physics
// as in engine/debris. Without particles, the cloud uses no memory, no pipeline and no time. Render thread only.
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

/// Parameters of the motion, as in debris::DebrisOptions and debris::CoarseField.
struct CloudLaw {
  std::size_t capacity = 100'000;
  glm::dvec3 gravity{0, 0, -9.81};                   // m/s², acceleration of gravity
  double air_density = 1.2, air_viscosity = 1.8e-5;  // kg/m³ and Pa·s
  // ratios of a particle's speed after a bounce to that before: normal to the surface, and tangential to the surface
  double restitution = 0.3, slide = 0.7;
  // s, time in which a particle's mass falls by a factor of e; age at which a particle is removed
  double decay_time = 2, lifetime = 6;
  double least_shown = 3e-5;  // m, smallest drawn diameter; smaller particles are drawn in this size but fainter
  glm::dvec3 origin{0};       // m, frame W, position of the distance field's first sample
  double spacing = 5e-4;      // m, spacing of the samples of the distance field
  // number of samples of the distance field along each axis (x is the slowest index); 0: no tissue to bounce off
  glm::ivec3 size{0};
};

struct CloudParticle {
  glm::vec3 p{0};     // m, frame W, position of the particle
  float age = 0;      // s, time since creation
  glm::vec3 v{0};     // m/s, velocity
  float mass = 0;     // kg, mass at creation; 0: removed by suction
  float chip = 0;     // m, diameter of a single chip; one particle represents several chips
  float density = 0;  // kg/m³, density of the chip's material
  // 1/s, rate at which drag slows the particle; ≥ 1e30: at rest; < 0: must be computed from the speed
  float rate = -1;
  std::uint8_t color[4] = {255, 255, 255, 0};  // sRGB, colour of the particle
};
static_assert(sizeof(CloudParticle) == 48);

class ParticleCloud {
 public:
  /// `distance`: samples of the distance field, m.
  ParticleCloud(gpu::Device& device, const CloudLaw& law, std::vector<float> distance);
  ~ParticleCloud();
  ParticleCloud(const ParticleCloud&) = delete;
  ParticleCloud& operator=(const ParticleCloud&) = delete;

  /// Adds particles up to the capacity; they move from the next step on. Returns the number of added particles.
  std::size_t add(std::span<const CloudParticle> born);
  /// Sets the suction nozzle at p_W: flow in m³/s (0: switched off), radius in m.
  void suck(const glm::dvec3& p_W, double flow, double radius);
  /// Adds dt seconds of motion. The next record() computes this motion.
  void advance(double dt);
  std::size_t alive() const { return count_; }
  std::size_t room() const { return law_.capacity - count_; }
  /// Returns true if the next record() will move or remove particles.
  bool changes() const { return pending_ > 0 && (count_ > 0 || shown_ > 0); }

  /// Records the compute commands for everything requested since the last record(). Call before the drawing pass.
  void record(VkCommandBuffer commands, int slot);
  /// Returns the buffer with the particles to draw (instances for ParticlePass). runs() gives their one or two ranges.
  VkBuffer instances() const { return instances_.buffer; }
  struct Run {
    std::uint32_t first = 0, count = 0;
  };
  std::vector<Run> runs() const;
  int pipelines() const { return pipeline_ ? 1 : 0; }
  int steps() const { return steps_; }  // number of compute steps so far
  /// For tests: waits for the GPU and reads the living particles, oldest first.
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
  std::vector<CloudParticle> born_;  // particles that were added since the last record()
  struct Cohort {
    double born_at;  // s, time at which the particles were added
    std::size_t count;
  };
  std::deque<Cohort> cohorts_;
  std::size_t first_ = 0, count_ = 0, shown_ = 0;
  // s: time_ is the time of all motion so far; pending_ is the time of the motion that the next record() computes
  double time_ = 0, pending_ = 0;
  glm::vec4 sink_{0};
  double nozzle_ = 0;  // m, radius of the suction nozzle
  int steps_ = 0;
};

}  // namespace typodont::render
