// Everything visible in a session at one time, except its tissue, computed from the session's events. Equal events give
// equal pictures, in a live session and when a recording is played. For one thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "engine/app/event_logs.h"
#include "engine/app/picture/debris_view.h"
#include "engine/app/picture/mirror_fog.h"
#include "engine/app/picture/soft_gum_view.h"
#include "engine/app/scene.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/task/heat.h"
#include "engine/app/task/warnings.h"
#include "engine/contract/contact.h"
#include "engine/contract/mouth_mirror.h"
#include "engine/contract/suction_tip.h"
#include "haptics/haptic_device.h"

namespace typodont {

class World {
 public:
  /// Step of session time (ns) in which chips, water, blood and fog move. The displayed numbers change at every sixth
  /// step.
  static constexpr Nanos kStep = kNanosPerSecond / 60;

  /// The scene at its start, without debris. The scene must outlive this object.
  explicit World(const Scene& scene);
  /// `gum`: the soft gum; null if the gum is rigid.
  World(const Scene& scene, std::shared_ptr<const haptics::SoftSurface> gum);
  World(const World&) = delete;
  World& operator=(const World&) = delete;
  /// Adds chips, water and suction. `tissue`: tissue at the session's start; used only in this call.
  void add_debris(const haptics::TissueVolume& tissue);
  /// Adds the temperatures of a scene with the key "heat". Call at the start of the session or before restart().
  /// `tissue`: tissue at the session's start. `rate`: ticks per second, Hz.
  void add_heat(const haptics::TissueVolume& tissue, double rate);
  /// Adds the warnings for a trainee with these levels; none if they are empty. Call at the start of the session.
  /// `tissue`: tissue at the session's start. Throws Error.
  void add_warnings(const haptics::TissueVolume& tissue, const session::WarningLevels& levels);
  /// Goes back to the start of the session. `debris`: if false, there are no chips and no water from now on.
  void restart(bool debris = true);

  /// Lets chips and water rest while nobody looks at them (DebrisView::rest).
  void rest_debris(bool rests) {
    if (debris_) debris_->rest(rests);
  }

  /// Sets the tool before the first tick.
  void place(const ServoTick& tick) { tick_ = readout_ = tick; }
  // Apply one event; call them in the order of time. A cut or loose piece comes before the tick to which it belongs.
  void apply(const ServoEvent& event);
  void apply(const CarverEvent& event);
  void apply(const ViewEvent& event);
  void apply(const ServoTick& tick);
  void apply(const Cut& cut);
  void apply(const LoosePiece& piece);
  void apply(const WaterSwitch& water);
  /// Applies the pose of the second hand, which holds the mouth mirror or the suction tip.
  void apply(const haptics::HandSample& left);
  void hold(const MouthMirror& mirror) { mirror_ = mirror; }
  /// Sets a line of text over the picture.
  void say(std::string notice) { notice_ = std::move(notice); }

  const Scene& scene() const { return scene_; }
  const Surroundings& surroundings() const { return around_; }
  std::span<const haptics::Tool> tools() const { return haptics::tool_set(scene_.servo); }
  const ServoTick& tick() const { return tick_; }
  /// The tool of the newest tick.
  const haptics::Tool& tool() const { return tools()[std::min<std::size_t>(tick_.tool, tools().size() - 1)]; }
  /// The tick whose numbers the text shows.
  const ServoTick& readout() const { return readout_; }
  const std::string& notice() const { return notice_; }
  double angle() const { return angle_; }  // rad, rotation of the bur about its axis
  MouthMirror mirror() const;
  const SuctionTip& suction_tip() const { return tip_; }
  const WaterSwitch& water() const { return water_; }
  double suction_flow() const { return water_.suction ? nozzle_.flow : 0; }        // m³/s, flow of the suction
  DebrisView* debris() { return debris_ && shows_debris_ ? &*debris_ : nullptr; }  // null: no debris is shown
  const DebrisView* debris() const { return debris_ && shows_debris_ ? &*debris_ : nullptr; }
  const HeatMeter* heat() const { return heat_ ? &*heat_ : nullptr; }  // null: temperatures are not computed
  /// The warning over the picture.
  Warning warning() const { return warnings_ ? warnings_->current() : Warning::kNone; }
  const SoftGumView* gum() const { return gum_ ? &*gum_ : nullptr; }

 private:
  void start();
  void reach(Nanos t);
  void step(Nanos t);

  const Scene& scene_;
  const Surroundings around_;
  std::optional<DebrisView> debris_;
  bool shows_debris_ = true;
  std::optional<SoftGumView> gum_;              // empty if the gum is rigid
  std::optional<HeatMeter> first_heat_, heat_;  // temperatures at the start, and current ones
  double rate_ = 0;                             // Hz, ticks per second; used only for temperatures
  std::optional<WarningMeter> warnings_;        // empty: no warnings
  std::optional<MirrorFog> fog_;                // empty if the fog does not change
  MouthMirror mirror_;
  SuctionTip tip_;
  WaterSwitch water_;
  debris::Suction beside_, nozzle_;  // suction nozzle at the start, and current one
  ServoTick tick_, readout_;
  std::string notice_;
  double angle_ = 0;
  Nanos next_ = 0;        // ns, time of the next step
  bool started_ = false;  // true after the first tick
};

/// Applies the events of a session's event logs to a World, in the order of their times. The result does not depend on
/// how often read() is called.
class WorldReader {
 public:
  /// World and event logs must outlive this object.
  WorldReader(World& world, const EventLogs& event_logs)
      : world_(world),
        servo_(event_logs.servo),
        carver_(event_logs.carver),
        view_(event_logs.view),
        left_(event_logs.left) {}
  /// Applies the new events up to the session time `until`, ns. Meanwhile, another thread may write later events.
  void read(Nanos until = std::numeric_limits<Nanos>::max());
  /// Number of the servo's events overwritten before they were read.
  std::uint64_t lost() const { return servo_.reader.lost(); }

 private:
  /// The next event of an event log.
  template <class Event>
  struct Next {
    explicit Next(const EventLog<Event>& event_log) : reader(event_log) {}
    void fetch(int rank);

    typename EventLog<Event>::Reader reader;
    Event event{};
    bool waits = false;
    std::pair<Nanos, int> order{};  // time, and rank among events of the same time
  };

  World& world_;
  Next<ServoEvent> servo_;
  Next<CarverEvent> carver_;
  Next<ViewEvent> view_;
  Next<haptics::HandSample> left_;
};

/// The speed (rad/s) at which the drawn tool rotates about its z axis. Right-handed threads turn clockwise, as seen
/// from the shank, when they enter.
double drawn_spin(const haptics::Tool& tool, double spindle);

}  // namespace typodont
