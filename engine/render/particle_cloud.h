// Particles on the GPU, moved by compute shaders with the physics of engine/debris. Without particles, a cloud uses
// no memory, pipeline or time. Render thread only.
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

/// Parameters of the particles' motion, as in debris::DebrisOptions and debris::CoarseField.
struct CloudLaw {
  std::size_t capacity = 100'000;
  glm::dvec3 gravity{0, 0, -9.81};                   // m/s², acceleration of gravity
  double air_density = 1.2, air_viscosity = 1.8e-5;  // kg/m³ and Pa·s
  // Ratio of the speed after and before a bounce: normal and tangential component.
  double restitution = 0.3, slide = 0.7;
  // Time in which the mass falls by the factor e, and time after which a particle is removed, s.
  double decay_time = 2, lifetime = 6;
  double min_shown = 3e-5;  // m; smaller particles are drawn with this size, but fainter
  glm::dvec3 origin{0};     // m, frame W, position of the distance field's first sample
  double spacing = 5e-4;    // m, distance between samples
  // Number of samples per axis, x slowest; 0: there is nothing to bounce off.
  glm::ivec3 size{0};
};

struct CloudParticle {
  glm::vec3 p{0};     // m, frame W, position of the particle
  float age = 0;      // s, time since creation
  glm::vec3 v{0};     // m/s, velocity
  float mass = 0;     // kg, mass at creation; 0: removed by suction
  float chip = 0;     // m, size of one chip; a particle represents several
  float density = 0;  // kg/m³, density of the chip's material
  // Rate of drag, 1/s; ≥ 1e30: the particle rests; < 0: computed from the speed.
  float rate = -1;
  std::uint8_t color[4] = {255, 255, 255, 0};  // sRGB, colour of the particle
};
static_assert(sizeof(CloudParticle) == 48);

class ParticleCloud {
 public:
  /// `distance`: samples of the signed distance to the tissue, m.
  ParticleCloud(gpu::Device& device, const CloudLaw& law, std::vector<float> distance);
  ~ParticleCloud();
  ParticleCloud(const ParticleCloud&) = delete;
  ParticleCloud& operator=(const ParticleCloud&) = delete;

  /// Adds particles, up to the capacity; they move from the next step on. Returns how many were added.
  std::size_t add(std::span<const CloudParticle> born);
  /// Sets the suction: position, flow (m³/s; 0: off) and radius of the nozzle (m).
  void suck(const glm::dvec3& p_W, double flow, double radius);
  /// Requests `dt` seconds of motion for the next record().
  void advance(double dt);
  std::size_t alive() const { return count_; }
  std::size_t room() const { return law_.capacity - count_; }
  /// Returns true if the next record() changes the particles.
  bool changes() const { return pending_ > 0 && (count_ > 0 || shown_ > 0); }

  /// Records all requested motion; call before the drawing pass.
  void record(VkCommandBuffer commands, int slot);
  /// Instances for ParticlePass, in the one or two ranges that runs() returns.
  VkBuffer instances() const { return instances_.buffer; }
  struct Run {
    std::uint32_t first = 0, count = 0;
  };
  std::vector<Run> runs() const;
  int pipelines() const { return pipeline_ ? 1 : 0; }
  int steps() const { return steps_; }  // number of compute steps so far
  /// Reads all particles, the oldest first. Waits for the GPU; for tests.
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
  // Duration of all motion so far, and of the motion in the next record(), s.
  double time_ = 0, pending_ = 0;
  glm::vec4 sink_{0};
  double nozzle_ = 0;  // m, radius of the suction nozzle
  int steps_ = 0;
};

}  // namespace typodont::render
