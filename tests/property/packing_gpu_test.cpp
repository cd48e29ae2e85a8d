// Tests that the three passes of the model "packing" give the same bits as the CPU when they run as Vulkan compute
// shaders on the present device.
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "engine/app/tissue/vulkan_sphere_passes.h"
#include "engine/base/units.h"
#include "haptics/contact/packing/compute_passes.h"
#include "haptics/contact/packing/packing_body.h"
#include "haptics/contact/packing/packing_model.h"
#include "haptics/packing.h"
#include "tests/support/haptic_bench.h"

namespace typodont::haptics::packing {
namespace {

using namespace literals;

constexpr const char* kTissue = R"({"voxel_mm": 0.1, "solids": [
    {"tissue": "enamel", "solid": {"sphere": {"radius_mm": 2.5}}},
    {"tissue": "dentin", "solid": {"sphere": {"radius_mm": 1.8}}}]})";

TissueVolume tissue() {
  return TissueVolume(read_solids(Json::parse(kTissue, "tissue")));
}
SpherePacking packed(std::size_t spheres) {
  PackOptions options;
  options.spheres = spheres;
  return pack_spheres(tissue(), options);
}
Tool cylinder() {
  Tool tool;
  tool.shape = HeadShape::kCylinder, tool.diameter = 1.0_mm, tool.length = 3.0_mm;
  return tool;
}
std::unique_ptr<SpherePasses> on_any_device(std::size_t spheres) {
  auto passes = make_vulkan_sphere_passes(spheres, true);
  if (!passes) throw std::runtime_error("no Vulkan device that computes in doubles (apt install mesa-vulkan-drivers)");
  return passes;
}

TEST(PackingOnAGpu, TheThreePassesGiveTheBitsOfTheCpu) {
  for (const Removal removal : {Removal::kMended, Removal::kAsPrinted}) {
    const SpherePacking packing = packed(5000);
    SphereTissue cut(packing, removal);
    const ToolSpheres tool = tool_spheres(cylinder(), 40);
    CutBuffers buffers(packing.size());
    // Spheres that were already cut from two sides. Some of them have disappeared.
    carve(cut, tool, {{0, 0, 3.6_mm}, {1, 0, 0, 0}}, {{0.3_mm, 0, 3.4_mm}, {1, 0, 0, 0}}, buffers,
          [](Place, const CutSphere&) {});
    carve(cut, tool, {{2.8_mm, 0, 0}, {1, 0, 0, 0}}, {{2.6_mm, 0.2_mm, 0}, {1, 0, 0, 0}}, buffers,
          [](Place, const CutSphere&) {});
    ComputePasses passes(on_any_device(packing.size()), {&tool, 1});
    passes.load(cut);
    const PassTimes times = compare_passes(cut, tool, passes, buffers, 25);
    EXPECT_TRUE(times.same) << passes.device();
  }
}

/// Passes that count down `left` in each call, and fail when it is zero.
class Failing final : public SpherePasses {
 public:
  Failing(std::unique_ptr<SpherePasses> real, int& left) : real_(std::move(real)), left_(left) {}
  std::string device() const override { return real_->device(); }
  std::size_t spheres() const noexcept override { return real_->spheres(); }
  std::size_t max_balls() const noexcept override { return real_->max_balls(); }
  bool load(std::span<const CutSphere> spheres, Removal removal) noexcept override {
    return real_->load(spheres, removal);
  }
  bool first_contact(std::span<const SweptBall> balls, FirstContact& first) noexcept override {
    return left_-- > 0 && real_->first_contact(balls, first);
  }
  bool overlaps(std::span<const RestingBall> balls, std::span<const SphereShare>& found) noexcept override {
    return left_-- > 0 && real_->overlaps(balls, found);
  }
  bool measure_removal(std::span<const CuttingBall> balls, std::span<const SphereShare>& found) noexcept override {
    return left_-- > 0 && real_->measure_removal(balls, found);
  }
  bool remove(std::span<const CuttingBall> balls, std::span<const SphereChange>& found) noexcept override {
    return left_-- > 0 && real_->remove(balls, found);
  }

 private:
  std::unique_ptr<SpherePasses> real_;
  int& left_;
};

class Method final : public ContactMethod {
 public:
  using Make = std::function<std::unique_ptr<SpherePasses>(std::size_t spheres)>;
  explicit Method(std::optional<Make> make) : make_(std::move(make)) {
    parameters_.spheres = 1500, parameters_.tool_spheres = 20;
  }
  std::string_view name() const override { return "packing"; }
  std::unique_ptr<ContactModel> make_model(const ServoSettings& settings) const override {
    if (!make_) return std::make_unique<PackingModel>(settings, parameters_);
    return std::make_unique<PackingModel>(settings, parameters_, (*make_)(parameters_.spheres));
  }
  std::unique_ptr<TissueBody> make_body(TissueVolume volume, std::span<const Tool> tools) const override {
    PackOptions options;
    options.spheres = parameters_.spheres;
    return std::make_unique<PackingBody>(std::move(volume), pack_spheres(volume, options), tools, parameters_);
  }

 private:
  Parameters parameters_;
  std::optional<Make> make_;
};

struct Drilled {
  std::vector<ServoTick> ticks;
  std::vector<CutSphere> left;
};
/// A cylinder bur is pressed on the tissue, drawn along it with changing tilt, and lifted. Then the stroke is undone,
/// and the bur returns.
Drilled drill(std::optional<Method::Make> make) {
  ServoSettings s;
  s.tool = cylinder();
  s.spindle.free_speed = 300.0_krpm;
  s.friction = false;
  s.method = std::make_shared<Method>(std::move(make));
  test::HapticBench bench(tissue(), s);
  Drilled drilled;
  for (int i = 0; i < 260; ++i) {
    const bool away = i >= 160 && i < 180;
    if (i == 170) bench.carver.undo();
    const double deep = std::min(i % 180, 60) * 0.015_mm;
    const dquat R = glm::angleAxis(0.1 + 0.001 * i, dvec3(1, 0, 0));
    drilled.ticks.push_back(
        bench.tick({dvec3(i * 0.003_mm, 0, away ? 8.0_mm : 2.5_mm + 1.6_mm - deep), R}, away ? 0 : 1));
  }
  const SphereTissue& left = static_cast<const PackingSnapshot&>(bench.servo.snapshot()).spheres;
  for (int i = 0; i < static_cast<int>(left.size()); ++i) drilled.left.push_back(left.sphere(i));
  return drilled;
}
void expect_same(const Drilled& a, const Drilled& b) {
  for (std::size_t i = 0; i < a.ticks.size(); ++i) {
    ASSERT_EQ(std::memcmp(&a.ticks[i].f_T_W, &b.ticks[i].f_T_W, sizeof(dvec3)), 0) << "tick " << i;
    ASSERT_EQ(std::memcmp(&a.ticks[i].X_WG, &b.ticks[i].X_WG, sizeof(Pose)), 0) << "tick " << i;
    ASSERT_EQ(a.ticks[i].removed, b.ticks[i].removed) << "tick " << i;
  }
  EXPECT_EQ(a.left, b.left);
}

TEST(PackingOnAGpu, ForcesAndCutsAreTheBitsOfTheCpuAlsoAfterAnUndo) {
  const Drilled processor = drill({});
  ASSERT_GT(processor.ticks.back().cuts, 100u);
  int left = 1'000'000;
  expect_same(processor, drill([&](std::size_t n) { return std::make_unique<Failing>(on_any_device(n), left); }));
  EXPECT_LT(left, 1'000'000 - 500) << "calls of the passes";
}

TEST(PackingOnAGpu, AfterAGpuFailureTheCpuContinuesWithTheSameBits) {
  const Drilled processor = drill({});
  for (const int calls : {0, 1, 60, 61, 62, 63}) {
    int left = calls;
    expect_same(processor, drill([&](std::size_t n) { return std::make_unique<Failing>(on_any_device(n), left); }));
    EXPECT_LT(left, 0) << "it never failed";
  }
}

TEST(PackingOnAGpu, TheValidationLayerReportsNothing) {
  gpu::DeviceOptions options;
  options.validation = true, options.doubles = true;
  const gpu::Device device = gpu::Device::create(options);
  const SpherePacking packing = packed(300);
  const SphereTissue tissue(packing, Removal::kMended);
  const ToolSpheres tool = tool_spheres(cylinder(), 10);
  {
    ComputePasses passes(vulkan_sphere_passes(device, packing.size()), {&tool, 1});
    passes.load(tissue);
    CutBuffers buffers(packing.size());
    EXPECT_TRUE(compare_passes(tissue, tool, passes, buffers, 4).same);
  }
  EXPECT_EQ(device.validation_messages(), 0);
}

TEST(PackingOnAGpu, ASoftwareGpuIsNeverChosen) {
  const auto devices = gpu::list_devices();
  ASSERT_FALSE(devices.empty());
  EXPECT_EQ(make_vulkan_sphere_passes(100, false) == nullptr, devices.front().processor);
}

}  // namespace
}  // namespace typodont::haptics::packing
