// Solids with a servo and a carver that run in lock-step, without scene files, for tests of the haptics alone.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "engine/base/units.h"
#include "haptics/contact/tissue_patch.h"
#include "haptics/contact_method.h"
#include "haptics/lockstep.h"
#include "haptics/solid.h"

namespace typodont::test {

inline MaterialTable plain_materials() {
  MaterialTable table{};
  table[static_cast<std::size_t>(Tissue::kEnamel)] = {1000, 30e9, 0.2, 0.15, 2950, dvec3(0.9)};
  table[static_cast<std::size_t>(Tissue::kDentin)] = {500, 8e9, 0.3, 0.22, 2150, dvec3(0.8)};
  return table;
}

/// Returns settings with a round tool of 1.2 mm that does not cut, and with a spring only. `model`: name of a contact
/// model, or {"NAME": {parameters}} as in a scene.
inline haptics::ServoSettings probe_settings(std::string_view model) {
  haptics::ServoSettings settings;
  settings.tool.diameter = settings.tool.length = 1.2e-3;
  settings.damping = 0;
  settings.friction = false;
  settings.cutting = false;
  settings.method = model.starts_with('{') ? haptics::read_contact_method(Json::parse(std::string(model), "model"))
                                           : haptics::contact_method(model, "model");
  return settings;
}
/// Returns the same settings with a bur at 300,000 rpm.
inline haptics::ServoSettings drill_settings(std::string_view model) {
  haptics::ServoSettings settings = probe_settings(model);
  settings.cutting = true;
  settings.spindle.free_speed = 300 * kKrpm;
  return settings;
}

/// Servo and carver in lock-step with a simple table of materials. Gives access to its parts.
struct HapticBench {
  haptics::LockStep steps;
  const haptics::ServoSettings& settings = steps.settings();
  haptics::Carver& carver = steps.carver();
  haptics::Servo& servo = steps.servo();
  ServoTick last;
  Cut cut;
  bool did_cut = false;
  double max_step = 0;    // N, largest change of the force in a tick
  double min_energy = 0;  // J, lowest value of the energy ledger
  Nanos t = 0;

  HapticBench(std::string_view tissue_json, const haptics::ServoSettings& s,
              const MaterialTable& materials = plain_materials())
      : HapticBench(haptics::TissueVolume(haptics::read_solids(Json::parse(tissue_json, "tissue"))), s, materials) {}
  HapticBench(haptics::TissueVolume volume, const haptics::ServoSettings& s,
              const MaterialTable& materials = plain_materials())
      : steps(std::move(volume), with_materials(s, materials)) {}
  HapticBench(const HapticBench&) = delete;
  HapticBench& operator=(const HapticBench&) = delete;

  static haptics::ServoSettings with_materials(haptics::ServoSettings s, const MaterialTable& materials) {
    s.materials = materials;
    return s;
  }

  /// Returns the servo's patch, if the contact model uses a distance field.
  const haptics::TissuePatch& patch() const { return dynamic_cast<const haptics::TissuePatch&>(servo.snapshot()); }
  /// Returns an empty patch of the size that the servo needs.
  haptics::TissuePatch empty_patch() const {
    return dynamic_cast<const haptics::TissuePatch&>(*carver.make_snapshot());
  }

  const ServoTick& tick(const Pose& X_WT, double pedal = 0, std::uint32_t tool = 0, std::uint32_t faults = 0) {
    const dvec3 f_before = last.f_T_W;
    did_cut = steps.tick({t, X_WT, pedal, tool, faults}, last, cut);
    max_step = std::max(max_step, glm::distance(last.f_T_W, f_before));
    min_energy = std::min(min_energy, last.energy);
    t += from_seconds(settings.tick);
    return last;
  }
};

}  // namespace typodont::test
