// An example of a contact method outside the library: one file, registered by name. Springs against an analytic ball at
// the origin; it removes nothing. After linking this file into a program, a scene may contain "model": {"ball": {…}}.
#include <algorithm>
#include <utility>

#include "engine/base/keys.h"
#include "engine/base/units.h"
#include "haptics/contact_method.h"
#include "haptics/servo.h"

namespace typodont::test {
namespace {

using namespace haptics;

class BallModel final : public ContactModel {
 public:
  BallModel(const ServoSettings& settings, double radius) : settings_(settings), radius_(radius) {}

  void adopt(Snapshot& fresh, PerTissue&) noexcept override { tissue_ = fresh; }
  const Snapshot& snapshot() const noexcept override { return tissue_; }
  double clearance(const Pose& X_WG) noexcept override { return std::max(0.0, distance(X_WG.p)); }
  bool is_free(std::uint32_t, const Pose& X_WG) noexcept override { return distance(X_WG.p) > 0; }
  void take_up(std::uint32_t) noexcept override {}

  void constrain(const ContactInput& in, Contact& out) noexcept override {
    const double depth = -distance(in.X_WT.p);
    out.spring.whole = true;
    out.touching = depth > 0;
    if (!out.touching) return;
    out.spring.depth = depth;
    out.spring.force = settings_.stiffness * depth * glm::normalize(in.X_WT.p);
    out.spring.stored = settings_.stiffness * depth * depth / 2;
  }
  void feel(const ContactInput&, Contact&, Felt& out) noexcept override {
    out.tissue[static_cast<std::size_t>(Tissue::kEnamel)] = 1;
    out.known_tissue = true;
  }
  Tissue tissue_at(const dvec3& p_W) const noexcept override {
    return glm::length(p_W) < radius_ ? Tissue::kEnamel : Tissue::kAir;
  }

 private:
  double distance(const dvec3& p_W) const { return glm::length(p_W) - radius_ - settings_.tool.radius(); }

  const ServoSettings& settings_;
  double radius_;  // m
  Snapshot tissue_;
};

class BallMethod final : public ContactMethod {
 public:
  explicit BallMethod(double radius) : radius_(radius) {}
  std::string_view name() const override { return "ball"; }
  std::unique_ptr<ContactModel> make_model(const ServoSettings& settings) const override {
    return std::make_unique<BallModel>(settings, radius_);
  }
  std::unique_ptr<TissueBody> make_body(TissueVolume tissue, std::span<const Tool> tools) const override {
    return default_contact_method()->make_body(std::move(tissue), tools);  // nothing is cut, so any body is suitable
  }

 private:
  double radius_;  // m
};

const ContactMethodRegistration registration{"ball", [](Keys& keys) {
                                               double radius = 4e-3;
                                               keys("radius_mm", radius, {0.1, 100, kMillimetre}, "radius of the ball");
                                               return std::make_shared<BallMethod>(radius);
                                             }};

}  // namespace
}  // namespace typodont::test
