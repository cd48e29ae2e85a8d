#include "haptics/contact/mesh_lod/mesh_lod_method.h"

#include <utility>

#include "engine/base/keys.h"
#include "engine/base/units.h"
#include "haptics/contact/mesh_lod/mesh_lod_body.h"
#include "haptics/contact/mesh_lod/mesh_lod_model.h"

namespace typodont::haptics::mesh_lod {

namespace {

constexpr long long kMinVertices = 16, kMaxVertices = 2'000'000;

class MeshLodMethod final : public ContactMethod {
 public:
  explicit MeshLodMethod(Parameters parameters) : parameters_(std::move(parameters)) {}
  std::string_view name() const override { return kName; }
  bool draws_own_surface() const override { return true; }
  std::unique_ptr<ContactModel> make_model(const ServoSettings& settings) const override {
    return std::make_unique<MeshLodModel>(settings, parameters_);
  }
  std::unique_ptr<TissueBody> make_body(TissueVolume tissue, std::span<const Tool> tools) const override {
    return std::make_unique<MeshLodBody>(std::move(tissue), tools, parameters_);
  }

 private:
  Parameters parameters_;
};

}  // namespace

SharedContactMethod read(Keys& keys) {
  Parameters p;
  std::size_t vertices = 0;
  keys("vertices", vertices, {kMinVertices, kMaxVertices}, "vertices of the base mesh; default: as the tissue's mesh");
  if (vertices > 0) p.levels.vertices = vertices;
  if (const auto levels = keys(
          "levels", kNumbers,
          "vertices of each level, finest first, at least 16; default: 100 %, 40.15 % and 22.46 % of the base mesh")) {
    long long max = kMaxVertices;
    for (const Json& level : levels->items()) {
      const long long count = level.integer(kMinVertices);
      if (count > max) level.fail("no more vertices than the level before");
      p.levels.levels.push_back(static_cast<std::size_t>(count));
      max = count;
    }
    if (p.levels.levels.empty()) levels->fail("at least one level");
  }
  if (const auto speeds =
          keys("switch_mm_s", kNumbers, "rising speeds at which the level changes; default [30, 120]")) {
    p.switch_speed.clear();
    double min = 1e-3;
    for (const Json& speed : speeds->items()) {
      const double v = speed.number(1e-3, 1e5);
      if (v < min) speed.fail("rising speeds");
      p.switch_speed.push_back(v * kMillimetre);
      min = v;
    }
  }
  if (keys.json() && keys.json()->boolean_or("as_printed", false)) p.hysteresis = 0, p.ramp = 0;
  keys("hysteresis", p.hysteresis, {0, 0.9}, "hysteresis around each of `switch_mm_s`, relative to the speed");
  keys("mapping", p.maps, "true: when the level changes, the contact is mapped to the new level, not computed again");
  keys("ramp_N_per_s", p.ramp, {0, 1e3}, "rate of change of the force after a change of level. 0: one step");
  keys("wall_limit_N", p.wall_limit, {0, 1e3}, "force at which a wall between two tissues yields");
  keys("as_printed", kFlag, "default false; true: the defaults of `hysteresis` and `ramp_N_per_s` are 0");
  return std::make_shared<MeshLodMethod>(std::move(p));
}

}  // namespace typodont::haptics::mesh_lod
