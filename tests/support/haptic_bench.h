// A scene without files: solids in, servo and carver in lock-step, for tests of the haptics alone.
#pragma once

#include <string_view>
#include <utility>

#include "haptics/lockstep.h"
#include "haptics/solid.h"
#include "haptics/surface_patch.h"

namespace typodont::test {

inline MaterialTable plain_materials() {
  MaterialTable table{};
  table[static_cast<std::size_t>(Tissue::kEnamel)] = {1000, 30e9, 0.2, 0.15, 2950, dvec3(0.9)};
  table[static_cast<std::size_t>(Tissue::kDentin)] = {500, 8e9, 0.3, 0.22, 2150, dvec3(0.8)};
  return table;
}

/// Whose materials a bench has: plain_materials(), or those of its settings.
enum class Materials { kPlain, kOfSettings };

/// The lock-step, by default with a plain table of materials, and its parts by name.
struct HapticBench {
  haptics::LockStep steps;
  const haptics::ServoSettings& settings = steps.settings();
  haptics::Carver& carver = steps.carver();
  haptics::Servo& servo = steps.servo();
  ServoTick last;
  Cut cut;
  bool did_cut = false;
  Nanos t = 0;

  HapticBench(std::string_view tissue_json, const haptics::ServoSettings& s)
      : HapticBench(haptics::TissueVolume(haptics::read_solids(Json::parse(tissue_json, "tissue"))), s) {}

  HapticBench(haptics::TissueVolume volume, const haptics::ServoSettings& s, Materials materials = Materials::kPlain)
      : steps(std::move(volume), materials == Materials::kPlain ? with_materials(s) : s) {}
  HapticBench(const HapticBench&) = delete;
  HapticBench& operator=(const HapticBench&) = delete;

  static haptics::ServoSettings with_materials(haptics::ServoSettings s) {
    s.materials = plain_materials();
    return s;
  }

  /// The servo's patch, of a field model.
  const haptics::SurfacePatch& patch() const { return dynamic_cast<const haptics::SurfacePatch&>(servo.snapshot()); }
  /// An empty patch of the right size.
  haptics::SurfacePatch empty_patch() const {
    return dynamic_cast<const haptics::SurfacePatch&>(*carver.make_snapshot());
  }

  const ServoTick& tick(const Pose& X_WT, double pedal = 0, std::uint32_t tool = 0, std::uint32_t faults = 0) {
    did_cut = steps.tick({t, X_WT, pedal, tool, faults}, last, cut);
    t += from_seconds(settings.tick);
    return last;
  }
};

}  // namespace typodont::test
