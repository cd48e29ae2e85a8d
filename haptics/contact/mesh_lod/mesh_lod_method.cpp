#include "haptics/contact/mesh_lod/mesh_lod_method.h"

#include <utility>

#include "engine/base/units.h"
#include "haptics/contact/mesh_lod/mesh_lod_body.h"
#include "haptics/contact/mesh_lod/mesh_lod_model.h"

namespace typodont::haptics::mesh_lod {

namespace {

constexpr long long kFewestVertices = 16, kMaxVertices = 2'000'000;

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

SharedContactMethod read(const std::optional<Json>& json) {
  Parameters p;
  if (!json) return std::make_shared<MeshLodMethod>(std::move(p));
  json->allow_only(
      {"vertices", "levels", "switch_mm_s", "hysteresis", "mapping", "ramp_N_per_s", "wall_limit_N", "as_printed"});
  if (const auto n = json->find("vertices"))
    p.levels.vertices = static_cast<std::size_t>(n->integer(kFewestVertices, kMaxVertices));
  if (const auto levels = json->find("levels")) {
    long long most = kMaxVertices;
    for (const Json& level : levels->items()) {
      const long long count = level.integer(kFewestVertices);
      if (count > most) level.fail("no more vertices than the level before");
      p.levels.levels.push_back(static_cast<std::size_t>(count));
      most = count;
    }
    if (p.levels.levels.empty()) levels->fail("at least one level");
  }
  if (const auto speeds = json->find("switch_mm_s")) {
    p.switch_speed.clear();
    double least = 1e-3;
    for (const Json& speed : speeds->items()) {
      const double v = speed.number(1e-3, 1e5);
      if (v < least) speed.fail("rising speeds");
      p.switch_speed.push_back(v * kMillimetre);
      least = v;
    }
  }
  if (json->boolean_or("as_printed", false)) p.hysteresis = 0, p.ramp = 0;
  p.hysteresis = json->number_or("hysteresis", p.hysteresis, 0, 0.9);
  p.maps = json->boolean_or("mapping", true);
  p.ramp = json->number_or("ramp_N_per_s", p.ramp, 0, 1e3);
  p.wall_limit = json->number_or("wall_limit_N", p.wall_limit, 0, 1e3);
  return std::make_shared<MeshLodMethod>(std::move(p));
}

}  // namespace typodont::haptics::mesh_lod
