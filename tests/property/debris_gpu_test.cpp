// Tests that particles computed on the GPU move like particles computed on the CPU.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/app/picture/debris_view.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "tests/support/stage.h"

namespace typodont::test {
namespace {

constexpr double kStep = 1.0 / 250;  // s

/// A ball of tissue with a radius of 5 mm, in a box of 4 cm.
struct Ball {
  std::vector<float> samples;
  debris::CoarseField field;
  Ball() {
    constexpr int n = 81;
    for_each_voxel(glm::ivec3(n), [&](int x, int y, int z) {
      samples.push_back(static_cast<float>(glm::length(dvec3(x - 40, y - 40, z - 40) * 5e-4) - 5e-3));
    });
    field.origin = dvec3(-0.02);
    field.size = glm::ivec3(n);
    field.distance = samples.data();
  }
};

Cut cut_of(std::uint64_t index) {
  Cut cut;
  cut.index = index;
  cut.removed[static_cast<std::size_t>(Tissue::kEnamel)] = 32e-12;
  cut.X_WA.p = cut.X_WB.p = {0, 0, 5.4e-3};
  cut.n_C_W = {0, 0, 1};
  cut.spindle = 300 * kKrpm;
  return cut;
}

MaterialTable stone() {
  MaterialTable materials{};
  for (auto& m : materials) m.density = 2900;
  return materials;
}

void step(Stage& stage, render::ParticleCloud& cloud, double dt) {
  cloud.advance(dt);
  gpu::run_once(stage.device, [&](VkCommandBuffer commands) { cloud.record(commands, 0); });
}

struct Both {
  Ball ball;
  Stage stage{{64, 64}};
  debris::DebrisOptions options{.capacity = 4000};
  debris::Debris host{options};
  render::ParticleCloud cloud{stage.device, cloud_law(options, ball.field, 3e-5), ball.samples};
  void cut(std::uint64_t index) {
    host.emit(cut_of(index), {.head_radius = 0.6e-3}, stone());
    std::vector<debris::NewParticle> born(kTissueCount * static_cast<std::size_t>(options.max_per_cut));
    PerTissue mass{};
    double dropped = 0;
    const std::size_t n = debris::create_particles(cut_of(index), {.head_radius = 0.6e-3}, stone(), options,
                                                   cloud.room(), born, mass, dropped);
    for (std::size_t i = 0; i < n; ++i) {
      const render::CloudParticle p = cloud_particle(born[i], dvec3(1));
      ASSERT_EQ(cloud.add({&p, 1}), 1u);
    }
  }
  void step_both(const debris::Suction* suction = nullptr) {
    // The CPU's suction needs steps of half a millisecond, which DebrisView also uses.
    const int parts = suction ? 8 : 1;
    for (int i = 0; i < parts; ++i) host.step(kStep / parts, ball.field, suction);
    step(stage, cloud, kStep);
  }
  /// Returns the sorted distances (m) between equal particles of CPU and GPU, without the particles that suction
  /// removed in either of them.
  std::vector<double> apart() {
    std::vector<debris::DebrisPoint> points(host.alive());
    const std::size_t n = host.write_points(points);
    std::vector<double> out;
    const auto gpu = cloud.read();
    if (n != gpu.size()) return {1e9};
    for (std::size_t i = 0; i < n; ++i) out.push_back(glm::length(dvec3(points[i].p_W - gpu[i].p)));
    std::sort(out.begin(), out.end());
    return out;
  }
};

TEST(DebrisOnTheGpu, ParticlesFlyAsOnTheCpu) {
  Both both;
  for (std::uint64_t i = 1; i <= 20; ++i) both.cut(i);
  // Before the first bounce, the two computations differ only in how often drag is updated. The effect is at most a
  // tenth; here it is much smaller.
  for (int i = 0; i < 3; ++i) both.step_both();
  const auto apart = both.apart();
  ASSERT_EQ(apart.size(), both.host.alive());
  EXPECT_LT(apart[apart.size() / 2], 1e-4);
  EXPECT_LT(apart[apart.size() * 99 / 100], 2e-3);
  EXPECT_EQ(both.stage.device.validation_messages(), 0);
}

TEST(DebrisOnTheGpu, ParticlesComeToRestWhereTheyDoOnTheCpu) {
  Both both;
  for (std::uint64_t i = 1; i <= 60; ++i) {
    both.cut(i);
    both.step_both();
  }
  for (int i = 0; i < 250; ++i) both.step_both();
  const auto gpu = both.cloud.read();
  std::vector<debris::DebrisPoint> host(both.host.alive());
  ASSERT_EQ(both.host.write_points(host), gpu.size());
  // A bounce enlarges tiny differences between two particles. So the whole cloud is compared, and not its particles.
  dvec3 mean_host(0), mean_gpu(0);
  double below_host = 0, below_gpu = 0;
  for (std::size_t i = 0; i < gpu.size(); ++i) {
    const auto near = [](const glm::vec3& p) { return glm::length(p) < 5.3e-3f; };
    below_host += near(host[i].p_W) ? 1 : 0;
    below_gpu += near(gpu[i].p) ? 1 : 0;
    mean_host += dvec3(host[i].p_W) / static_cast<double>(gpu.size());
    mean_gpu += dvec3(gpu[i].p) / static_cast<double>(gpu.size());
    EXPECT_GT(glm::length(gpu[i].p), 4.7e-3) << "within the tissue";
  }
  EXPECT_NEAR(below_gpu, below_host, 0.05 * static_cast<double>(gpu.size()));
  const double spread = [&] {
    double sum = 0;
    for (const auto& p : host) sum += glm::length(dvec3(p.p_W) - mean_host);
    return sum / static_cast<double>(host.size());
  }();
  EXPECT_LT(glm::length(mean_gpu - mean_host), 0.05 * spread);
}

TEST(DebrisOnTheGpu, ItsMassIsTheMassOfTheCutAndDecaysToZero) {
  Both both;
  for (std::uint64_t i = 1; i <= 10; ++i) both.cut(i);
  both.step_both();
  double mass = 0;
  for (const auto& p : both.cloud.read()) mass += p.mass;
  EXPECT_NEAR(mass, 10 * 32e-12 * 2900, 1e-6 * mass);
  const int lives = static_cast<int>(both.options.lifetime / kStep) + 2;
  for (int i = 0; i < lives / 20; ++i) step(both.stage, both.cloud, 20 * kStep);
  EXPECT_EQ(both.cloud.alive(), 0u);
}

TEST(DebrisOnTheGpu, ASuctionNozzleDrawsItIn) {
  Both both;
  const debris::Suction suction{{0.004, 0, 0.009}, 5e-3, 4e-3};
  both.cloud.suck(suction.p_W, suction.flow, suction.radius);
  for (std::uint64_t i = 1; i <= 20; ++i) both.cut(i);
  for (int i = 0; i < 100; ++i) both.step_both(&suction);
  const auto gpu = both.cloud.read();
  const auto gone =
      static_cast<double>(std::count_if(gpu.begin(), gpu.end(), [](const auto& p) { return p.mass == 0; }));
  std::vector<debris::DebrisPoint> left(both.host.alive());
  const auto gone_host = static_cast<double>(both.host.alive() - both.host.write_points(left));
  EXPECT_GT(gone_host, 0.1 * static_cast<double>(gpu.size()));
  EXPECT_NEAR(gone, gone_host, 0.1 * static_cast<double>(gpu.size()));
}

TEST(DebrisOnTheGpu, NoChipIsCarriedPastTheNozzleInOneLongStep) {
  Both both;
  const debris::Suction suction{{0.004, 0, 0.009}, 5e-3, 1e-3};
  for (std::uint64_t i = 1; i <= 20; ++i) both.cut(i);
  for (int i = 0; i < 25; ++i) both.step_both();
  both.cloud.suck(suction.p_W, suction.flow, suction.radius);
  const auto before = both.cloud.read();
  constexpr double kLong = 1.0 / 30;  // s, time of a picture on a slow machine
  step(both.stage, both.cloud, kLong);
  both.host.step(kLong, both.ball.field, &suction);
  const auto after = both.cloud.read();
  int gone = 0;
  for (std::size_t i = 0; i < after.size(); ++i) {
    gone += after[i].mass == 0 ? 1 : 0;
    const auto away = [&](const auto& p) { return glm::length(dvec3(p.p) - suction.p_W); };
    if (after[i].mass > 0 && away(before[i]) < 8e-3) {
      EXPECT_LT(away(after[i]), away(before[i]) + 2e-3) << i;
    }
  }
  std::vector<debris::DebrisPoint> left(both.host.alive());
  const auto gone_host = static_cast<double>(both.host.alive() - both.host.write_points(left));
  EXPECT_GT(gone_host, 0);
  EXPECT_NEAR(gone, gone_host, 0.02 * static_cast<double>(after.size())) << gone_host << " on the processor";
}

TEST(DebrisOnTheGpu, WithoutParticlesThereIsNoWorkAndNoPipeline) {
  Both both;
  for (int i = 0; i < 5; ++i) both.step_both();
  EXPECT_EQ(both.cloud.pipelines(), 0);
  EXPECT_EQ(both.cloud.steps(), 0);
  EXPECT_FALSE(both.cloud.changes());
  EXPECT_TRUE(both.cloud.runs().empty());
}

TEST(DebrisOnTheGpu, IsDrawnAndRedrawnWhenItMoves) {
  Both both;
  both.stage.renderer->resize({160, 128});
  render::Frame frame = frame_of(desk(0.03, 0.024, 0.35));
  frame.cloud = &both.cloud;
  both.stage.draw(frame);
  const render::Picture empty = both.stage.eye(0);
  EXPECT_FALSE(both.stage.draw(frame).drawn) << "nothing moved";
  for (std::uint64_t i = 1; i <= 20; ++i) both.cut(i);
  both.cloud.advance(kStep);
  const render::FrameStats stats = both.stage.draw(frame);
  EXPECT_TRUE(stats.drawn);
  EXPECT_GT(compare(empty, both.stage.eye(0), 4).pixels, 20);
  EXPECT_EQ(both.stage.device.validation_messages(), 0);
}

}  // namespace
}  // namespace typodont::test
