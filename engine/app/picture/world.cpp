#include "engine/app/picture/world.h"

#include <cmath>
#include <type_traits>
#include <utility>
#include <variant>

#include "engine/app/surroundings/soft_gum.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

constexpr Nanos kReadoutSteps = 6;  // steps between two changes of the displayed numbers, so that they can be read
constexpr double kBeside = 9e-3;    // m, distance of the default suction nozzle from the tooth's top, in +y of frame W

}  // namespace

World::World(const Scene& scene) : World(scene, soft_gum(scene.surroundings)) {}

World::World(const Scene& scene, std::shared_ptr<const haptics::SoftSurface> gum)
    : scene_(scene), around_(make_surroundings(scene.surroundings)) {
  if (gum) gum_.emplace(std::move(gum), around_);
  start();
}

void World::add_debris(const haptics::TissueVolume& tissue) {
  glm::ivec3 lo, hi;
  tissue.bounds(lo, hi);
  const dvec3 top = tissue.frame().to_world(dvec3((lo.x + hi.x) / 2.0, (lo.y + hi.y) / 2.0, hi.z));
  beside_ = scene_.suction.value_or(debris::Suction{.p_W = top + dvec3(0, kBeside, 0)});
  debris_.emplace(scene_.servo.materials, tissue, water_of(scene_, around_));
  start();
}

void World::add_heat(const haptics::TissueVolume& tissue, double rate) {
  first_heat_ = heat_meter(scene_, tissue);
  heat_ = first_heat_;
  rate_ = rate;
}

void World::add_warnings(const haptics::TissueVolume& tissue, const session::WarningLevels& levels) {
  if (!levels.empty()) warnings_.emplace(scene_, tissue, levels);
}

void World::start() {
  fog_ = mirror_fog_of(scene_);
  mirror_ = scene_.mouth_mirror;
  tip_ = scene_.suction_tip;
  nozzle_ = beside_;
  tick_ = readout_ = {};
  angle_ = 0;
  started_ = false;
  apply(WaterSwitch{0, scene_.spray_on, scene_.suction_on});
}

void World::restart(bool debris) {
  shows_debris_ = debris;
  if (debris_) debris_->restart();
  if (gum_) gum_->reset();
  heat_ = first_heat_;
  if (warnings_) warnings_->restart();
  start();
}

/// Advances chips, water, blood, fog and displayed numbers to the time t.
void World::reach(Nanos t) {
  if (!started_) return;
  for (; next_ < t; next_ += kStep) step(next_);
}

void World::step(Nanos t) {
  constexpr double kSeconds = 1e-9 * kStep;
  if (gum_) gum_->follow(t);
  if (DebrisView* const moving = debris()) {
    moving->hold(tick_, tool());
    moving->step(kSeconds);
  }
  if (fog_) fog_->advance(kSeconds, mirror_, fog_->air(mirror_, tick_, debris_ && debris_->spraying()));
  if (t / kStep % kReadoutSteps != 0) return;
  readout_ = tick_;
  if (warnings_) warnings_->evaluate(tick_, t);
}

void World::apply(const ServoTick& tick) {
  reach(tick.t);
  if (std::exchange(started_, true)) {
    angle_ = std::fmod(angle_ + drawn_spin(tool(), tick.spindle) * to_seconds(tick.t - tick_.t), 2 * kPi);
  } else {
    next_ = (tick.t / kStep + 1) * kStep;
    readout_ = tick;
  }
  tick_ = tick;
  if (warnings_) warnings_->add(tick);
  if (!heat_) return;
  ServoTick timed = tick;
  session::set_scored_times({&timed, 1}, rate_);  // so that the score reports the same temperatures
  heat_->add({&timed, 1}, water_.spray);
}

void World::apply(const Cut& cut) {
  if (!debris()) return;
  reach(cut.t);
  // Event logs hold a cut before its tick, so tick_ is still the previous tick.
  debris_->add(cut, tools()[cut.tool], tick_.contact_area, to_seconds(cut.t - tick_.t));
}

void World::apply(const LoosePiece& piece) {
  if (!debris()) return;
  reach(piece.t);
  debris_->add(piece);
}

void World::apply(const ServoEvent& event) {
  if (const auto* const tick = std::get_if<ServoTick>(&event)) {
    apply(*tick);
  } else if (const auto* const cut = std::get_if<Cut>(&event)) {
    apply(*cut);
  } else if (gum_) {
    gum_->apply(event);
  }
}

void World::apply(const CarverEvent& event) {
  if (const auto* const piece = std::get_if<LoosePiece>(&event)) apply(*piece);
}

void World::apply(const ViewEvent& event) {
  if (const auto* const water = std::get_if<WaterSwitch>(&event)) apply(*water);
}

void World::apply(const haptics::HandSample& left) {
  if (!hand_holds_suction(scene_)) {
    mirror_ = held(scene_.mouth_mirror, left.X_WT);
    return;
  }
  tip_.X_WS = left.X_WT;
  nozzle_.p_W = left.X_WT.p;
  apply(water_);
}

void World::apply(const WaterSwitch& water) {
  water_ = water;
  if (!debris_) {
    water_.spray = water_.suction = false;
    return;
  }
  debris_->spray(water.spray);
  water_.spray = debris_->spraying();
  debris_->suck(water.suction ? std::optional(nozzle_) : std::nullopt);
}

MouthMirror World::mirror() const {
  MouthMirror mirror = mirror_;
  if (fog_ && mirror.diameter > 0) mirror.fog = fog_->fog();
  return mirror;
}

template <class Event>
void WorldReader::Next<Event>::fetch(int rank) {
  if (waits || !reader.next(event)) return;
  waits = true;
  const auto time = [&](const auto& e) {
    if constexpr (requires { e.t; }) return e.t;
    return order.first;  // an event without a time has the time of the event before it
  };
  constexpr int kTickRank = 4;  // a tick comes after all other events of the same time
  if constexpr (requires { std::variant_size<Event>::value; }) {
    order = {std::visit(time, event), rank};
    if constexpr (std::is_same_v<Event, ServoEvent>)
      if (std::holds_alternative<ServoTick>(event)) order.second = kTickRank;
  } else {
    order = {time(event), rank};
  }
}

void WorldReader::read(Nanos until) {
  const auto apply_if_first = [&](auto& next, const auto&... others) {
    if (!next.waits || next.order.first > until || ((others.waits && others.order < next.order) || ...)) return false;
    world_.apply(next.event);
    return !(next.waits = false);
  };
  do {
    servo_.fetch(0), carver_.fetch(1), view_.fetch(2), left_.fetch(3);
  } while (apply_if_first(servo_, carver_, view_, left_) || apply_if_first(carver_, servo_, view_, left_) ||
           apply_if_first(view_, servo_, carver_, left_) || apply_if_first(left_, servo_, carver_, view_));
}

double drawn_spin(const haptics::Tool& tool, double spindle) {
  return tool.implant && tool.implant->threaded() ? -spindle : spindle;
}

}  // namespace typodont
