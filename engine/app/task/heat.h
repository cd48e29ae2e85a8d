// Temperature of pulp and bone during a session, from the ticks: the work of the edges warms the tissue around the
// head, the spray cools it. Beside the score; 2 % of a core.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/contract/contact.h"
#include "engine/session/heat.h"
#include "engine/session/score.h"
#include "haptics/tissue_volume.h"
#include "haptics/tool.h"

namespace typodont {

/// Every tick in order, in groups of any size. One thread only.
class HeatMeter {
 public:
  /// Harm of the pulp, K above the body's temperature, and of bone, °C.
  static constexpr double kBody = 37, kPulpHarm = 5.5, kBoneHarm = 47;

  /// `flow`: m³/s of the spray. ServoTick::tool is an index in `tools`.
  HeatMeter(const session::HeatConstants& constants, const session::HeatSettings& settings, double flow,
            const haptics::TissueVolume& start, std::span<const haptics::Tool> tools);
  /// `sprays`: the water is on; it flows while the tool turns.
  void add(std::span<const ServoTick> ticks, bool sprays);
  session::HeatMeasures result() const { return measures_; }
  /// °C now, of the pulp's place farthest from the body's temperature, and of bone's hottest place 0.5 mm from the
  /// wall.
  double pulp() const { return pulp_; }
  double bone() const { return bone_; }

 private:
  struct Head {
    haptics::HeadField field;
    double reach = 0;  // m
  };
  void step(const ServoTick& tick, double dt, bool wet);
  void observe(double dt);

  session::HeatConstants constants_;
  session::HeatBath dry_, wet_;
  session::HeatGrid grid_;
  std::vector<Head> heads_;
  std::vector<std::size_t> pulp_cells_, warmed_;
  // m, of each bone cell, its least distance from a cutting head; far: beyond kWatched
  std::vector<float> wall_;
  std::vector<std::size_t> watched_;  // bone within kWatched of a cut
  session::HeatMeasures measures_;
  double energy_ = 0;  // J, of cutting since the last step
  double pulp_ = kBody, bone_ = kBody, above_ = 0;
  std::optional<Nanos> last_t_;
  double since_ = 0, time_ = 0;  // s, since the last step; of the session
};

struct Scene;
/// Empty without "heat" in the scene. Throws Error.
std::optional<HeatMeter> heat_meter(const Scene& scene, const haptics::TissueVolume& start);

}  // namespace typodont
