#include "engine/app/hands/expert_hand.h"

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"

namespace typodont {

namespace {

/// Parameters of the motion: a target point moves along the line, and the hand pulls the tool to it. Lengths are for a
/// tooth; they are multiplied by ExpertGrip::size.
struct Lead {
  // Speed through the air, m/s: of a hand instrument, and of a running drill.
  static constexpr double travel_pace = 60e-3, drill_travel_pace = 65e-3;
  static constexpr double scrape_pace = 27e-3;  // m/s, largest speed of a scraping hand instrument
  // Speed to which a scraping instrument slows before it reverses, m/s; time constant of the slowing, s.
  static constexpr double turning_pace = 12e-3, turning_time = 0.01;
  // Slowing near the end of a cut: the hand reacts late, so a fast cut would go too far.
  static constexpr double slowing_time = 0.04;  // s, time constant near a cut's end
  static constexpr double end_pace = 0.4e-3;    // m/s, speed at the end of a cut
  // The target point waits while the tool is farther from it than this, m.
  static constexpr double ahead = 0.06e-3;
  // The target point waits until the tool is nearer to the line of the cut than this, m.
  static constexpr double beside = 0.022e-3;
  // For bulk removal with a coarse tool: the target point waits until the tool is nearer to the line than this, m.
  static constexpr double rough_beside = 0.05e-3;
  // A cut that ends with a stop is complete when the tool is nearer to the cut's end than this, m.
  static constexpr double there = 0.01e-3;
  // The tool makes progress if it comes nearer to the target by this, m.
  static constexpr double progress = 2.5e-6;
  // Scraping ends after a pass in which the tool's distance to the line always was smaller than this, m.
  static constexpr double near_line = 0.03e-3;
  // Scraping also ends after a pass that removed less than this volume, m³, or than this fraction of the run's most
  // useful pass.
  static constexpr double useful_pass = 5e-13, useful_fraction = 0.1;
  static constexpr double patience = 3;  // s; after this time without progress, a stroke is abandoned
  // The lead is the displacement from the target point to the hand. It is a low-pass filtered gain times the
  // displacement from the tool to the target. The coupling converts the lead to a force.
  static constexpr double reaction_time = 0.05;  // s, time constant of the hand
  static constexpr double gain = 50;             // lead before the filter / displacement from tool to target point
  // Upper limit of gain · tick duration / reaction_time. If this product is larger, the hand oscillates.
  static constexpr double steady_gain = 1.5;
  // The upper limit of the lead is adjusted until the force is as planned: d(limit)/dt = this factor (1/s) ·
  // ExpertGrip::lead · force error / mean force.
  static constexpr double lead_per_force = 15;
  // Smallest and largest upper limit of the lead (see `gain`), as factors on ExpertGrip::lead.
  static constexpr double least_most_lead = 0.25, max_lead = 3;
  // The lead's upper limit may always grow to this, m: soft bone needs a longer lead for the same force.
  static constexpr double always_allowed_lead = 2e-3;
  // In the air, the hand slows if the tool is more than `waits_from` (m) behind. At `waits_from` + `waits_over` (m),
  // the hand has the fraction `min_pace` of its full speed.
  static constexpr double waits_from = 3e-3, waits_over = 1e-3, min_pace = 0.02;
};

/// Contacts and tremor of a hand on a tooth, as measured in hands (docs/reality.md, "Hands").
struct Rhythm {
  // s; longest contact; the same for a coarse diamond bur; pause after a contact, which gives 1.36 contacts per second
  static constexpr double contact = 0.37, coarse_contact = 10, pause = 1 / 1.36 - contact;
  static constexpr double release = 0.08;  // s, from the end of the push to the end of the contact
  // m, distance from the tissue in the first and in the second half of a pause
  static constexpr double away = 0.3e-3, near = 0.05e-3;
  // Force at a coarse diamond bur's end / force at its side: 0.45 N on a crown's occlusal surface, 1.71 N on its walls.
  // The end has contact if the cosine between contact normal and tool axis exceeds `end`.
  static constexpr double end_force = 0.45 / 1.71, end = 0.7;
  static constexpr double tremor = 8.1;              // Hz
  static constexpr double tremor_amplitude = 31e-6;  // m, of the sine on each axis; rms of all three together: 38 µm
};

}  // namespace

PlanningExpert::PlanningExpert(const Scene& scene, haptics::Carver& carver, double rate)
    : carver_(carver),
      expert_(scene, load_untouched(scene), kHandMargins),
      hand_(expert_.plan(carver.volume()), rate, expert_.grip()) {}

bool PlanningExpert::read(haptics::HandSample& sample) noexcept {
  while (!hand_.read(sample)) {
    std::vector<ExpertLeg> rest = expert_.plan(carver_.volume());
    if (rest.empty()) return false;
    hand_.go_on(rest);
  }
  return true;
}

void ExpertHand::go_on(std::vector<ExpertLeg>& legs) noexcept {
  legs_.swap(legs);
  leg_ = 0;
  way_ = exit_legs_.size();
  along_ = waited_ = worst_ = 0;
  nearest_ = std::numeric_limits<double>::infinity();
  removed_ = total(seen_.removed);
  most_removed_ = 0;
  back_ = false;
  run_ = 0;
  run_from_ = from_;
}

haptics::DeviceInfo ExpertHand::info_for(double rate) {
  haptics::DeviceInfo info;
  info.address = "expert:";
  info.model = "a hand that knows the task";
  info.rate = rate;
  info.force_limit = info.torque_limit = 1e9;  // this hand can withstand any force
  info.chooses_tools = true;
  return info;
}

ExpertHand::ExpertHand(std::vector<ExpertLeg> legs, double rate, const ExpertGrip& grip)
    : info_(info_for(rate)),
      grip_(grip),
      legs_(std::move(legs)),
      dt_(1 / rate),
      from_(legs_.front().to),
      free_(from_),
      max_lead_(grip.lead * Lead::least_most_lead) {
  seen_.X_WG = seen_.X_WT = from_;
}

void ExpertHand::next_leg() noexcept {
  const bool out = way_ < exit_legs_.size();
  const ExpertLeg& leg = out ? exit_legs_[way_] : legs_[leg_];
  from_ = leg.to;
  if (leg.kind == ExpertLeg::Kind::kMove) free_ = leg.to;
  ++(out ? way_ : leg_);
  along_ = waited_ = worst_ = 0;
  nearest_ = std::numeric_limits<double>::infinity();
  removed_ = total(seen_.removed);
  most_removed_ = 0;
  back_ = false;
  run_ = leg_;
  run_from_ = from_;
}

void ExpertHand::end_scraping() noexcept {
  along_ = waited_ = 0;
  if (!back_ && legs_[leg_].end_pace > 0) {
    from_ = legs_[leg_++].to;
    return;
  }
  const double removed = total(seen_.removed) - removed_;
  if (!back_) most_removed_ = std::max(most_removed_, removed);
  if (!back_ && worst_ > grip_.size * Lead::near_line &&
      removed > std::max(Lead::useful_pass, Lead::useful_fraction * most_removed_)) {
    back_ = true;
    removed_ = total(seen_.removed);
    worst_ = 0;
  } else if (!back_) {
    next_leg();
  } else if (leg_ > run_) {
    --leg_;
    from_ = leg_ == run_ ? run_from_ : legs_[leg_ - 1].to;
  } else {
    back_ = false;
    worst_ = 0;
  }
}

void ExpertHand::leave() noexcept {
  const ExpertLeg& left = legs_[leg_];
  const dvec3 shank = left.to.R * dvec3(0, 0, 1);
  const auto over = [&](Pose pose) {
    pose.p += std::max(0.0, glm::dot(free_.p - pose.p, shank)) * shank;
    return pose;
  };
  exit_legs_.fill(left);
  for (ExpertLeg& leg : exit_legs_) leg.kind = ExpertLeg::Kind::kMove;
  exit_legs_[0].to = over({seen_.X_WG.p, left.to.R});
  exit_legs_[1].to = over(legs_[std::min(leg_ + 1, legs_.size() - 1)].to);
  next_leg();
  from_ = {seen_.X_WG.p, left.to.R};
  way_ = 0;
}

void ExpertHand::keep_rhythm(const ExpertLeg& leg) noexcept {
  if (leg.kind == ExpertLeg::Kind::kMove) beat_ = 0, pauses_ = false;
  if (leg.kind != ExpertLeg::Kind::kCut || !on_tooth()) return;
  const double longest = pauses_ ? Rhythm::pause : leg.coarse ? Rhythm::coarse_contact : Rhythm::contact;
  if (pauses_ || seen_.depth > 0) beat_ += dt_;
  if (beat_ < longest + (pauses_ ? Rhythm::release : -Rhythm::release)) return;
  beat_ = 0;
  pauses_ = !pauses_;
  left_at_W_ = seen_.X_WG.p;
  leaves_W_ = seen_.n_C_W + seen_.X_WG.R * dvec3(0, 0, 1);
}

bool ExpertHand::read(haptics::HandSample& sample) noexcept {
  if (leg_ >= legs_.size() && way_ >= exit_legs_.size()) return false;
  using Kind = ExpertLeg::Kind;
  const ExpertLeg leg = way_ < exit_legs_.size() ? exit_legs_[way_] : legs_[leg_];
  const Pose &a = back_ ? leg.to : from_, &b = back_ ? from_ : leg.to;
  const double length = glm::length(b.p - a.p);
  const auto place = [&] { return length > 0 ? a.p + (along_ / length) * (b.p - a.p) : b.p; };
  const dvec3 away = place() - seen_.X_WG.p, way = length > 0 ? (b.p - a.p) / length : dvec3(0);
  const double off = glm::length(away), beside = glm::length(away - glm::dot(away, way) * way);
  keep_rhythm(leg);
  if (!pauses_) waited_ += dt_;
  bool done = false, stuck = false;
  if (leg.kind == Kind::kWait) {
    along_ = length;
    const double now = -total(seen_.removed);
    if (waited_ < 1.5 * dt_) filled_ = now;
    done = waited_ >= leg.seconds || (leg.volume > 0 && now - filled_ >= leg.volume);
  } else if (leg.kind == Kind::kTake) {
    along_ = length;
    done = seen_.tool == leg.tool || waited_ > 10;
  } else if (!pauses_) {
    // The speed is lower near both ends of a run (strokes without a stop between them).
    const bool first = leg_ == run_, last = leg.end_pace <= 0;
    const double from_turn = (back_ ? last : first) ? along_ : length,
                 to_turn = (back_ ? first : last) ? length - along_ : length;
    const double pace =
        leg.kind == Kind::kMove ? (leg.pedal > 0 ? Lead::drill_travel_pace : Lead::travel_pace) *
                                      std::clamp(1 - (off - Lead::waits_from) / Lead::waits_over, Lead::min_pace, 1.0)
        : leg.kind == Kind::kCut
            ? std::min(kExpertCutPace, std::max(leg.end_pace, Lead::end_pace) + (length - along_) / Lead::slowing_time)
            : std::min(Lead::scrape_pace, Lead::turning_pace + std::min(from_turn, to_turn) / Lead::turning_time);
    const bool may = leg.kind != Kind::kCut || (off < grip_.size * Lead::ahead &&
                                                beside < grip_.size * (leg.rough ? Lead::rough_beside : Lead::beside));
    if (may && along_ < length) {
      along_ = std::min(length, along_ + pace * dt_);
      waited_ = 0;
      nearest_ = off;
    } else if (off < nearest_ - grip_.size * Lead::progress) {
      waited_ = 0;
      nearest_ = off;
    }
    if (leg.kind == Kind::kScrape) worst_ = std::max(worst_, beside);
    done = along_ >= length &&
           (leg.kind != Kind::kCut ||
            off < (leg.end_pace > 0 ? grip_.size * (leg.coarse ? Lead::ahead : Lead::beside) : Lead::there));
    stuck = !done && waited_ > Lead::patience;
    done = done || stuck;
  }
  const bool presses = leg.kind == Kind::kCut || leg.kind == Kind::kScrape;
  const bool scrapes = leg.kind == Kind::kScrape;
  dvec3 wanted = presses
                     ? std::min(Lead::gain, Lead::steady_gain * Lead::reaction_time / dt_) * (place() - seen_.X_WG.p)
                     : dvec3(0);
  const double size = glm::length(wanted);
  const bool limited = size > max_lead_;
  if (limited) wanted *= max_lead_ / size;
  if (pauses_) wanted = left_at_W_ + (beat_ < Rhythm::pause / 2 ? Rhythm::away : Rhythm::near) * leaves_W_ - place();
  // Adjusts max_lead_: soft tissue needs a longer lead (displacement from target point to hand) for the same force.
  const bool end = leg.coarse && std::abs(glm::dot(seen_.n_C_W, seen_.X_WG.R * dvec3(0, 0, 1))) > Rhythm::end;
  // N, planned force minus measured force
  const double too_little = leg.force * (end ? Rhythm::end_force : 1) - glm::length(seen_.f_T_W);
  if (presses && !pauses_ && (limited || too_little < 0))
    max_lead_ = std::clamp(max_lead_ + grip_.lead * dt_ * Lead::lead_per_force * too_little / grip_.force,
                           grip_.lead * Lead::least_most_lead,
                           std::max(grip_.lead * Lead::max_lead, grip_.size * Lead::always_allowed_lead));
  lead_ += std::min(1.0, dt_ / Lead::reaction_time) * (wanted - lead_);
  const double fraction = length > 0 ? along_ / length : 1;
  sample.t = from_seconds(static_cast<double>(ticks_++) * dt_);
  const double phase = 2 * kPi * Rhythm::tremor * to_seconds(sample.t),
               tremor = leg.drills && on_tooth() ? Rhythm::tremor_amplitude : 0;
  sample.X_WT = {place() + lead_ + tremor * dvec3(std::sin(phase), std::sin(phase + 2), std::sin(phase + 4)),
                 glm::slerp(a.R, b.R, fraction)};
  sample.pedal = leg.pedal;
  sample.tool = leg.tool;
  if (done && stuck && leg.kind == Kind::kCut)
    leave();
  else if (done && scrapes)
    end_scraping();
  else if (done)
    next_leg();
  return true;
}

}  // namespace typodont
