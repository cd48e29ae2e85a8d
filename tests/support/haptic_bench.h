// A scene without files: solids in, a servo and its carver in lock-step out. The same order of steps as the program's
// deterministic loop, for tests of the haptics alone.
#pragma once

#include <string_view>
#include <utility>

#include "haptics/carver.h"
#include "haptics/servo.h"
#include "haptics/solid.h"

namespace typodont::test {

inline MaterialTable plain_materials() {
  MaterialTable table{};
  table[static_cast<std::size_t>(Tissue::kEnamel)] = {1000, 30e9, 0.2, 0.15, 2950, dvec3(0.9)};
  table[static_cast<std::size_t>(Tissue::kDentin)] = {500, 8e9, 0.3, 0.22, 2150, dvec3(0.8)};
  return table;
}

struct HapticBench {
  haptics::ServoSettings settings;
  haptics::Carver carver;
  haptics::Servo servo;
  haptics::SurfacePatch spare;
  ServoTick last;
  Cut cut;
  bool did_cut = false;
  Nanos t = 0;

  HapticBench(std::string_view tissue_json, const haptics::ServoSettings& s)
      : HapticBench(haptics::TissueVolume(haptics::read_solids(Json::parse(tissue_json, "tissue"))), s) {}

  HapticBench(haptics::TissueVolume volume, const haptics::ServoSettings& s)
      : settings(complete(s, volume.frame())),
        carver(std::move(volume), haptics::tray(settings)),
        servo(settings, haptics::patch_edge_for(haptics::tray(settings), settings.frame.voxel)) {
    spare.resize(servo.patch().n);
  }

  static haptics::ServoSettings complete(haptics::ServoSettings s, const VoxelFrame& frame) {
    s.frame = frame;
    s.materials = plain_materials();
    return s;
  }

  const ServoTick& tick(const Pose& X_WT, double pedal = 0, std::uint32_t tool = 0, std::uint32_t faults = 0) {
    if (t == 0) last.X_WT = last.X_WG = X_WT;
    if (carver.patch_due(last)) {
      carver.cut_out(carver.patch_center(last), spare);
      servo.adopt(spare);
    }
    const Nanos start = thread_cpu_time();
    did_cut = servo.tick({t, X_WT, pedal, tool, faults}, last, cut);
    last.cpu_time = thread_cpu_time() - start;
    if (did_cut) carver.apply(cut);
    t += from_seconds(settings.tick);
    return last;
  }
};

}  // namespace typodont::test
