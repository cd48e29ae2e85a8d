// Computes the temperature of pulp and bone during a session from the ticks: cutting warms the tissue around the head,
// the spray cools it. Takes 2 % of a processor core.
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

/// Call add() with all ticks in order, in any number of calls. One thread only.
class HeatMeter {
 public:
  /// Body temperature, °C. Harmful temperatures: of the pulp, K above kBody; of bone, °C.
  static constexpr double kBody = session::HeatMeasures::kBody, kPulpHarm = 5.5, kBoneHarm = 47;

  /// `flow`: flow of the spray, m³/s. `tools`: ServoTick::tool is an index into them.
  HeatMeter(const session::HeatConstants& constants, const session::HeatSettings& settings, double flow,
            const haptics::TissueVolume& start, std::span<const haptics::Tool> tools);
  /// Adds ticks. `sprays`: the water is on; it flows only while the tool turns.
  void add(std::span<const ServoTick> ticks, bool sprays);
  session::HeatMeasures result() const { return measures_; }
  /// All cells and their current temperatures; steps(): number of changes so far.
  const session::HeatGrid& grid() const { return grid_; }
  std::uint64_t steps() const { return steps_; }
  /// Current temperatures, °C. pulp(): where the pulp differs most from kBody. bone(): the hottest bone 0.5 mm from the
  /// surface of the cut.
  double pulp() const { return pulp_; }
  double bone() const { return bone_; }

 private:
  struct Head {
    haptics::HeadField field;
    double reach = 0;  // m, distance from the head's centre to its farthest point
  };
  void step(const ServoTick& tick, double dt, bool wet);
  void observe(double dt);

  session::HeatConstants constants_;
  session::HeatBath dry_, wet_;
  session::HeatGrid grid_;
  std::vector<Head> heads_;
  std::vector<std::size_t> pulp_cells_, warmed_;
  // For each bone cell: its smallest distance from a cutting head so far, m. 1000: never near one.
  std::vector<float> wall_;
  std::vector<std::size_t> watched_;  // indices of bone cells near a cut
  session::HeatMeasures measures_;
  std::uint64_t steps_ = 0;
  double energy_ = 0;  // J, energy of cutting since the last step
  double pulp_ = kBody, bone_ = kBody, above_ = 0;
  std::optional<Nanos> last_t_;
  double since_ = 0, time_ = 0;  // s: time since the last step, and session time
};

struct Scene;
/// The heat meter of a scene; empty if the scene has no key "heat". Throws Error.
std::optional<HeatMeter> heat_meter(const Scene& scene, const haptics::TissueVolume& start);

}  // namespace typodont
