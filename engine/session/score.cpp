#include "engine/session/score.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "engine/base/error.h"
#include "engine/base/keys.h"
#include "engine/base/units.h"

namespace typodont::session {

namespace {

// Tremor is at 8 to 12 Hz. The fourth difference of positions at intervals h has the gain sin⁴(π·f·h) for the frequency
// f; h = 50 ms shows the octave around 10 Hz. The power of strokes with sharp turns follows a power law of f, so in
// this octave it is the geometric mean of the powers around 5 and 20 Hz.
constexpr double kTremorLag = 0.025;  // s, half a period of 20 Hz
constexpr double kTremorGain = 0.9;   // power of a sine of 9 Hz after the filter
// Positions are averaged over this time before the path length is computed, s; tremor would lengthen the path.
constexpr double kPathBlock = 0.1;
constexpr double kFreeBetween = 0.1;   // s; a longer time without contact ends a stroke
constexpr double kMinRemoved = 1e-15;  // m³; a contact that removes less tissue is no stroke

}  // namespace

void set_scored_times(std::span<ServoTick> ticks, double servo_rate) {
  for (ServoTick& tick : ticks) tick.t = from_seconds(static_cast<double>(tick.index) / servo_rate);
}

HandMeter::HandMeter(double servo_rate)
    : rate_(servo_rate),
      lag_(static_cast<std::size_t>(std::max(1.0, std::round(servo_rate * kTremorLag)))),
      recent_(16 * lag_ + 1),
      block_size_(static_cast<std::uint64_t>(std::max(1.0, std::round(servo_rate * kPathBlock)))) {}

void HandMeter::add(std::span<const ServoTick> ticks) {
  for (const ServoTick& tick : ticks) {
    const dvec3& p = tick.X_WT.p;
    const bool held = tick.faults & bits(Fault::kHeld);  // emergency key is on: no force, no cut
    if (!is_finite(p) || !is_finite(tick.f_T_W)) continue;
    if (first_) {
      t_first_ = tick.t;
      std::ranges::fill(recent_, p);  // begins as if the hand had rested at p
    }
    t_last_ = tick.t;
    recent_[ticks_++ % recent_.size()] = p;

    block_sum_ += p;
    if (++block_count_ == block_size_) {
      const dvec3 mean = block_sum_ / static_cast<double>(block_size_);
      if (have_mean_) path_ += glm::length(mean - last_mean_);
      last_mean_ = mean;
      have_mean_ = true;
      block_sum_ = dvec3(0);
      block_count_ = 0;
    }

    const double removed = total(tick.removed);
    if (first_) removed_last_ = removed;
    stroke_cut_ += std::max(0.0, removed - removed_last_);
    const bool contact = !held && (tick.depth > 0 || tick.contact_area > 0);
    if (contact) {
      const double force = glm::length(tick.f_T_W);
      ++contact_ticks_;
      force_sum_ += force;
      force_max_ = std::max(force_max_, force);
      for (std::size_t i = 0, lag = 4 * lag_; i < octaves_.size(); ++i, lag /= 2) {
        // The middle of each of the three differences is 8 · lag_ ticks ago.
        const auto at = [&](std::size_t k) {
          return recent_[(ticks_ + 8 * lag_ + 2 * lag - k * lag) % recent_.size()];
        };
        const auto moved = [&](std::size_t k) { return at(k) - at(k + 1); };
        const dvec3 fast = (moved(0) - 3.0 * moved(1) + 3.0 * moved(2) - moved(3)) / 16.0;
        octaves_[i] += glm::dot(fast, fast);
      }
      if (!in_stroke_ || to_seconds(tick.t - last_contact_) > kFreeBetween) {
        end_stroke();
        in_stroke_ = true;
        stroke_cut_ = std::max(0.0, removed - removed_last_);
      }
      last_contact_ = tick.t;
    }
    removed_last_ = removed;
    first_ = false;
  }
}

void HandMeter::end_stroke() {
  if (in_stroke_ && stroke_cut_ > kMinRemoved) ++strokes_;
  in_stroke_ = false;
}

HandMeasures HandMeter::result() const {
  HandMeasures m;
  m.time = to_seconds(t_last_ - t_first_);
  m.contact_time = static_cast<double>(contact_ticks_) / rate_;
  m.force_mean = contact_ticks_ ? force_sum_ / static_cast<double>(contact_ticks_) : 0;
  m.force_max = force_max_;
  m.path_length = path_;
  m.strokes = strokes_ + (in_stroke_ && stroke_cut_ > kMinRemoved ? 1 : 0);
  const double tremor = std::max(0.0, octaves_[1] - std::sqrt(octaves_[0] * octaves_[2])) / kTremorGain;
  m.tremor_rms = contact_ticks_ ? std::sqrt(tremor / static_cast<double>(contact_ticks_)) : 0;
  return m;
}

namespace {

/// True for all tissues except caries and old fillings.
bool is_healthy(Tissue t) {
  return t != Tissue::kAir && t != Tissue::kCaries && t != Tissue::kAmalgam && t != Tissue::kComposite;
}

constexpr double kMm3 = 1e9;  // mm³ per m³
// Explored fraction for full points; the tip cannot reach everything.
constexpr double kEnoughExplored = 0.9;
// Tolerance of a pocket's depth, m: an examiner's repeated readings agree this well at over 90 % of the sites (Andrade
// and others, Braz Oral Res 26 (2012) 57).
constexpr double kReadWithin = 1e-3;

/// True if the task is to measure pockets.
bool probes(const ScoreInput& in) {
  return in.explore && !in.explore->sites.empty();
}

double removed_fraction(const ScoreInput& in, Tissue t) {
  const auto i = static_cast<std::size_t>(t);
  return in.before[i] > 0 ? std::clamp((in.before[i] - in.after[i]) / in.before[i], 0.0, 1.0) : 1.0;
}

double healthy_removed(const ScoreInput& in) {
  double sum = 0;
  for (std::size_t i = 0; i < kTissueCount; ++i) {
    if (is_healthy(static_cast<Tissue>(i))) sum += std::max(0.0, in.before[i] - in.after[i]);
  }
  return sum;
}

/// Volume cut too much (`sign` = 1) or too little (-1), mm³: from the voxels if they were measured, else from the
/// tissues' volumes.
std::optional<double> against_ideal(const ScoreInput& in, double sign) {
  if (in.cavity && in.cavity->has_ideal) return (sign > 0 ? in.cavity->over_volume : in.cavity->under_volume) * kMm3;
  if (!in.ideal) return std::nullopt;
  double sum = 0;
  for (std::size_t i = 1; i < kTissueCount; ++i) sum += std::max(0.0, sign * ((*in.ideal)[i] - in.after[i]));
  return sum * kMm3;
}

/// A measure of the score: name, unit, whether more or less is better, and the function that computes it.
struct Measure {
  const char* name;
  const char* unit;
  Best best;
  std::optional<double> (*value)(const ScoreInput&);
  bool of_hand = false;  // true: measures the hand's motion; false: the tissue
  Basis basis = Basis::kReplay;
};

std::optional<double> if_caries(const ScoreInput& in, double value) {
  if (in.before[static_cast<std::size_t>(Tissue::kCaries)] <= 0) return std::nullopt;
  return value;
}

/// A measure of the cavity, in the report's unit.
template <auto Member>
std::optional<double> of_cavity(const ScoreInput& in, double per_unit) {
  if (!in.cavity) return std::nullopt;
  const std::optional<double> value = (*in.cavity).*Member;
  if (!value) return std::nullopt;
  return *value * per_unit;
}
std::optional<double> depth_of(const ScoreInput& in, Place CavityMeasures::*place) {
  if (!in.cavity || !in.cavity->has_ideal) return std::nullopt;
  return ((*in.cavity).*place).depth * 1e3;
}

constexpr double kDegreesPerRadian = 180 / kPi;
using In = const ScoreInput&;
using Value = std::optional<double>;
using Bed = ImplantBedMeasures;

/// A measure of the implant's drilled hole; empty if it is unknown (negative).
template <auto Member>
Value of_bed(In in, double per_unit) {
  if (!in.implant || !in.implant->bed.found || in.implant->bed.*Member < 0) return std::nullopt;
  return per_unit * in.implant->bed.*Member;
}
/// A distance from the drilled hole, mm; empty if it is a metre or more: there is nothing near.
template <auto Member>
Value near_bed(In in) {
  const Value metres = of_bed<Member>(in, 1);
  return metres && *metres < 1 ? Value(1e3 * *metres) : std::nullopt;
}

// Smaller values of a measure, in the measure's unit, count as 0.
constexpr double kMinMeasured = 1e-6;
// m³; if a smaller volume of tissue changed, this counts as no work.
constexpr double kMinChanged = 1e-12;

constexpr Measure kMeasures[] = {
    {"residual_caries_mm3", "mm³", Best::kAtMost,
     [](In in) { return if_caries(in, std::max(0.0, in.after[static_cast<std::size_t>(Tissue::kCaries)]) * kMm3); }},
    {"residual_caries_percent", "%", Best::kAtMost,
     [](In in) { return if_caries(in, 100.0 * (1.0 - removed_fraction(in, Tissue::kCaries))); }},
    {"over_cut_mm3", "mm³", Best::kAtMost, [](In in) { return against_ideal(in, 1); }},
    {"under_cut_mm3", "mm³", Best::kAtMost, [](In in) { return against_ideal(in, -1); }},
    {"over_cut_depth_mm", "mm", Best::kAtMost, [](In in) { return depth_of(in, &CavityMeasures::over); }},
    {"under_cut_depth_mm", "mm", Best::kAtMost, [](In in) { return depth_of(in, &CavityMeasures::under); }},
    {"contour_rms_um", "µm", Best::kAtMost, [](In in) { return of_cavity<&CavityMeasures::contour>(in, 1e6); }},
    {"floor_depth_mm", "mm", Best::kNear, [](In in) { return of_cavity<&CavityMeasures::floor_depth>(in, 1e3); }},
    {"floor_flatness_um", "µm", Best::kAtMost,
     [](In in) { return of_cavity<&CavityMeasures::floor_flatness>(in, 1e6); }},
    {"floor_tilt_deg", "°", Best::kAtMost,
     [](In in) { return of_cavity<&CavityMeasures::floor_tilt>(in, kDegreesPerRadian); }},
    {"taper_deg", "°", Best::kNear, [](In in) { return of_cavity<&CavityMeasures::taper>(in, kDegreesPerRadian); }},
    {"axial_depth_mm", "mm", Best::kNear, [](In in) { return of_cavity<&CavityMeasures::wall_depth>(in, 1e3); }},
    {"isthmus_mm", "mm", Best::kNear, [](In in) { return of_cavity<&CavityMeasures::isthmus>(in, 1e3); }},
    {"wall_thickness_mm", "mm", Best::kAtLeast,
     [](In in) { return of_cavity<&CavityMeasures::wall_thickness>(in, 1e3); }},
    {"margin_roughness_um", "µm", Best::kAtMost,
     [](In in) { return of_cavity<&CavityMeasures::margin_roughness>(in, 1e6); }},
    {"cup_center_mm", "mm", Best::kAtMost, [](In in) { return of_cavity<&CavityMeasures::cup_offset>(in, 1e3); }},
    {"cup_radius_mm", "mm", Best::kNear,
     [](In in) { return in.cavity && in.cavity->cup ? Value(in.cavity->cup->radius * 1e3) : std::nullopt; }},
    {"cup_angle_deg", "°", Best::kAtMost,
     [](In in) { return of_cavity<&CavityMeasures::cup_tilt>(in, kDegreesPerRadian); }},
    {"healthy_removed_mm3", "mm³", Best::kAtMost, [](In in) -> Value { return healthy_removed(in) * kMm3; }},
    {"gingiva_removed_mm3", "mm³", Best::kAtMost,
     [](In in) -> Value {
       const auto i = static_cast<std::size_t>(Tissue::kGingiva);
       const bool around = in.damage && in.damage->gum;
       return in.before[i] > 0 || around
                  ? Value((std::max(0.0, in.before[i] - in.after[i]) + (around ? in.damage->gum_volume : 0)) * kMm3)
                  : std::nullopt;
     }},
    {"neighbour_removed_mm3", "mm³", Best::kAtMost,
     [](In in) {
       return in.damage && in.damage->neighbours ? Value(in.damage->neighbour_volume * kMm3) : std::nullopt;
     }},
    {"protected_removed_mm3", "mm³", Best::kAtMost,
     [](In in) { return of_cavity<&CavityMeasures::kept_removed>(in, kMm3); }},
    {"pulp_removed_mm3", "mm³", Best::kAtMost,
     [](In in) -> Value {
       const auto i = static_cast<std::size_t>(Tissue::kPulp);
       return in.before[i] > 0 ? Value(std::max(0.0, in.before[i] - in.after[i]) * kMm3) : std::nullopt;
     }},
    {"pulp_distance_mm", "mm", Best::kAtLeast,
     [](In in) -> Value {
       if (in.cavity) return of_cavity<&CavityMeasures::pulp_distance>(in, 1e3);
       return in.pulp_distance ? Value(*in.pulp_distance * 1e3) : std::nullopt;
     }},
    {"pulp_exposed_mm2", "mm²", Best::kAtMost, [](In in) { return of_cavity<&CavityMeasures::pulp_exposed>(in, 1e6); }},
    {"lesions_found_percent", "%", Best::kAtLeast,
     [](In in) {
       return in.explore && in.explore->lesions > 0 ? Value(100.0 * in.explore->found / in.explore->lesions)
                                                    : std::nullopt;
     },
     false, Basis::kHand},
    {"false_finds", "", Best::kAtMost,
     [](In in) { return in.explore && !probes(in) ? Value(in.explore->false_finds) : std::nullopt; }, false,
     Basis::kHand},
    {"explored_percent", "%", Best::kAtLeast,
     [](In in) { return in.explore && !probes(in) ? Value(100 * in.explore->explored) : std::nullopt; }},
    {"sites_within_1mm_percent", "%", Best::kAtLeast,
     [](In in) {
       return probes(in)
                  ? Value(100.0 * in.explore->sites_within(kReadWithin) / static_cast<double>(in.explore->sites.size()))
                  : std::nullopt;
     },
     false, Basis::kHand},
    {"probing_force_N", "N", Best::kAtMost,
     [](In in) { return probes(in) ? Value(in.explore->probing_force) : std::nullopt; }},
    {"implant_phases_percent", "%", Best::kAtLeast,
     [](In in) { return in.implant ? Value(100 * in.implant->phases_done()) : std::nullopt; }, false, Basis::kTicks},
    {"implant_entry_mm", "mm", Best::kAtMost, [](In in) { return of_bed<&Bed::entry_error>(in, 1e3); }},
    {"implant_apex_mm", "mm", Best::kAtMost, [](In in) { return of_bed<&Bed::apex_error>(in, 1e3); }},
    {"implant_angle_deg", "°", Best::kAtMost, [](In in) { return of_bed<&Bed::axis_error>(in, kDegreesPerRadian); }},
    {"bed_depth_mm", "mm", Best::kNear, [](In in) { return of_bed<&Bed::depth>(in, 1e3); }},
    {"bed_diameter_mm", "mm", Best::kNear, [](In in) { return of_bed<&Bed::diameter>(in, 1e3); }},
    {"bed_ovality_mm", "mm", Best::kAtMost, [](In in) { return of_bed<&Bed::ovality>(in, 1e3); }},
    {"cortical_perforation_percent", "%", Best::kAtMost, [](In in) { return of_bed<&Bed::perforated>(in, 100); }},
    {"canal_distance_mm", "mm", Best::kAtLeast, [](In in) { return near_bed<&Bed::canal_distance>(in); }},
    {"neighbour_distance_mm", "mm", Best::kAtLeast, [](In in) { return near_bed<&Bed::neighbour_distance>(in); }},
    {"insertion_torque_Ncm", "N·cm", Best::kNear,
     [](In in) { return in.implant && in.implant->placed ? Value(100 * in.implant->insertion_torque) : std::nullopt; }},
    {"bone_contact_percent", "%", Best::kAtLeast,
     [](In in) {
       return in.implant && in.implant->bone_contact >= 0 ? Value(100 * in.implant->bone_contact) : std::nullopt;
     }},
    {"over_force_s", "s", Best::kAtMost,
     [](In in) { return in.implant ? Value(in.implant->over_force) : std::nullopt; }, false, Basis::kTicks},
    {"pulp_heating_K", "K", Best::kAtMost,
     [](In in) { return in.heat && in.heat->pulp ? Value(in.heat->pulp_max - HeatMeasures::kBody) : std::nullopt; },
     false, Basis::kHand},
    {"bone_temperature_C", "°C", Best::kAtMost,
     [](In in) -> Value {
       if (in.heat && in.heat->bone) return in.heat->bone_max;
       return in.implant ? Value(in.implant->hottest) : std::nullopt;
     },
     false, Basis::kTicks},
    {"force_mean_N", "N", Best::kAtMost, [](In in) -> Value { return in.hand.force_mean; }, true},
    {"force_max_N", "N", Best::kAtMost, [](In in) -> Value { return in.hand.force_max; }, true},
    {"path_length_mm", "mm", Best::kAtMost, [](In in) -> Value { return in.hand.path_length * 1e3; }, true,
     Basis::kHand},
    {"time_s", "s", Best::kAtMost, [](In in) -> Value { return in.hand.time; }, true, Basis::kTicks},
    {"contact_time_s", "s", Best::kAtMost, [](In in) -> Value { return in.hand.contact_time; }, true, Basis::kTicks},
    {"strokes", "", Best::kAtMost, [](In in) -> Value { return in.hand.strokes; }, true, Basis::kTicks},
    {"tremor_rms_um", "µm", Best::kAtMost, [](In in) -> Value { return in.hand.tremor_rms * 1e6; }, true, Basis::kHand},
};

Value value_of(const Measure& measure, const ScoreInput& in) {
  const Value value = measure.value(in);
  return value && std::abs(*value) < kMinMeasured ? 0.0 : value;
}

const Measure* find_measure(std::string_view name) {
  const auto it =
      std::find_if(std::begin(kMeasures), std::end(kMeasures), [&](const Measure& m) { return m.name == name; });
  return it == std::end(kMeasures) ? nullptr : it;
}

/// Completed fraction of the task: of the phases of an implant; of the pockets read; of the lesions found and the
/// surface explored (mean); of the changes to the target shape; or of the caries removed. If there was no
/// caries at the start, it is 1 as soon as the tissue has changed.
double completion(const ScoreInput& in) {
  if (probes(in)) return static_cast<double>(in.explore->sites_read()) / static_cast<double>(in.explore->sites.size());
  if (in.explore) {
    const double found = in.explore->lesions > 0 ? static_cast<double>(in.explore->found) / in.explore->lesions : 1.0;
    return 0.5 * found + 0.5 * std::min(1.0, in.explore->explored / kEnoughExplored);
  }
  if (in.implant) return in.implant->phases_done();
  if (in.cavity && in.cavity->has_ideal && in.cavity->wanted > 0) return in.cavity->done / in.cavity->wanted;
  if (!in.ideal && in.before[static_cast<std::size_t>(Tissue::kCaries)] > 0)
    return removed_fraction(in, Tissue::kCaries);
  if (!in.ideal) {
    double changed = 0;
    for (std::size_t i = 1; i < kTissueCount; ++i) changed += std::abs(in.before[i] - in.after[i]);
    return changed > kMinChanged ? 1.0 : 0.0;
  }
  double wanted = 0, done = 0;
  for (std::size_t i = 1; i < kTissueCount; ++i) {
    const double goal = std::max(0.0, in.before[i] - (*in.ideal)[i]);
    wanted += goal;
    done += std::clamp(in.before[i] - in.after[i], 0.0, goal);
  }
  return wanted > 0 ? done / wanted : 1.0;
}

/// Names of Best in files, in the order of its enumerators.
constexpr std::array<std::string_view, 3> kBestNames = {"at_most", "at_least", "near"};

/// Distance of a value from the rule's target if the value is worse than the target; otherwise 0.
double excess(const ScoreRule& rule, double value) {
  switch (rule.best) {
    case Best::kAtMost:
      return std::max(0.0, value - rule.target);
    case Best::kAtLeast:
      return std::max(0.0, rule.target - value);
    case Best::kNear:
      return std::abs(value - rule.target);
  }
  return 0;
}

}  // namespace

std::vector<std::string> known_score_names() {
  std::vector<std::string> names;
  for (const Measure& m : kMeasures) names.emplace_back(m.name);
  return names;
}

std::string_view unit_of(std::string_view name) {
  const Measure* m = find_measure(name);
  return m ? m->unit : "";
}

std::vector<ScoreRule> default_rules(const ScoreInput& input) {
  const double caries_mm3 = input.before[static_cast<std::size_t>(Tissue::kCaries)] * kMm3;
  // Critical errors, mm³: a damaged neighbour and an opened pulp (limits of the volumes: estimates).
  constexpr double kNicked = 0.5, kPulpOpened = 0.02;
  const char* ours = "Typodont's default; set it in the scene";
  std::vector<ScoreRule> rules;
  if (probes(input)) {
    rules = {
        {"sites_within_1mm_percent", 100, 15, 60, Best::kAtLeast,
         "Repeated readings agree within 1 mm at over 90 % of the sites (Andrade 2012)"},
        {"probing_force_N", 0.3, 0.2, 30, Best::kAtMost, "Probing force of 0.2 to 0.25 N; the limit is an estimate"}};
  } else if (input.explore) {
    rules = {{"lesions_found_percent", 100, 20, 50, Best::kAtLeast, ours},
             {"false_finds", 0, 1, 15, Best::kAtMost, ours},
             {"explored_percent", 100 * kEnoughExplored, 20, 20, Best::kAtLeast, ours}};
  } else {
    rules = {{"residual_caries_percent", 0, 10, 40, Best::kAtMost, ours},
             {"residual_caries_mm3", 0, 1, 0, Best::kAtMost, ours},
             {"over_cut_mm3", 0, 2, 20, Best::kAtMost, ours},
             {"under_cut_mm3", 0, 2, 10, Best::kAtMost, ours},
             {"over_cut_depth_mm", 0, 0.3, 5, Best::kAtMost, ours},
             {"under_cut_depth_mm", 0, 0.3, 5, Best::kAtMost, ours},
             {"gingiva_removed_mm3", 0, 1, 5, Best::kAtMost, ours},
             {"neighbour_removed_mm3", 0, 0.2, 15, Best::kAtMost, ours, kNicked},
             {"protected_removed_mm3", 0, 0.2, 15, Best::kAtMost, ours},
             {"pulp_removed_mm3", 0, 0.05, 20, Best::kAtMost, ours, kPulpOpened},
             {"pulp_distance_mm", 0.5, 0.25, 5, Best::kAtLeast,
              "Half a millimetre of dentin left over the pulp; Typodont's default"}};
  }
  if (!probes(input))
    rules.push_back(input.explore ? ScoreRule{"force_mean_N", 3.33, 2.14, 5, Best::kAtMost,
                                              "Dentists press explorers with 3.33 N (SD 2.14 N)"}
                                  : ScoreRule{"force_mean_N", 1.0, 1.0, 5, Best::kAtMost,
                                              "Hand forces of 0.34 to 1.03 N measured on teeth"});
  rules.insert(rules.end(),
               {{"force_max_N", 3.0, 2.0, 5, Best::kAtMost, "Lateral loads of up to 3 N measured on teeth"},
                {"path_length_mm", 0, 1000, 0, Best::kAtMost, ours},
                {"time_s", 600, 300, 2, Best::kAtMost, ours},
                {"contact_time_s", 0, 300, 0, Best::kAtMost, ours},
                {"strokes", 0, 50, 0, Best::kAtMost, ours},
                {"tremor_rms_um", 100, 100, 3, Best::kAtMost, ours}});
  // Without an ideal shape: to reach the caries, some healthy tissue must be removed. Points are lost only if the
  // removed healthy tissue has a larger volume than the caries.
  if (input.explore || input.ideal || (input.cavity && input.cavity->has_ideal)) {
    rules.push_back({"healthy_removed_mm3", 0, 10, 0, Best::kAtMost, ours});
  } else {
    rules.push_back({"healthy_removed_mm3", caries_mm3, std::max(2.0, caries_mm3), 20, Best::kAtMost,
                     "As much as the caries, for the access; Typodont's default"});
  }
  return rules;
}

std::optional<double> default_target(std::string_view name) {
  ScoreInput working, exploring, probing;
  exploring.explore.emplace();
  probing.explore.emplace().sites.resize(1);
  for (const ScoreInput& in : {working, exploring, probing}) {
    for (const ScoreRule& rule : default_rules(in)) {
      if (rule.name == name) return rule.target;
    }
  }
  return std::nullopt;
}

namespace {

bool has_ideal(const ScoreInput& in) {
  return in.ideal || in.cavity_ideal;
}

/// The score's input for a perfect result: the tissue equals the ideal shape.
ScoreInput as_the_ideal(const ScoreInput& input) {
  ScoreInput in = input;
  in.hand = {};
  in.cavity = input.cavity_ideal;
  in.after = input.ideal.value_or(input.before);
  if (in.heat) in.heat->pulp_max = in.heat->bone_max = HeatMeasures::kBody;
  if (in.damage) in.damage->neighbour_volume = in.damage->gum_volume = 0;
  return in;
}

/// Declares the keys of a rule. A missing target is the default for measures of the hand and without an ideal shape.
void describe_rule(Keys& keys, ScoreRule& rule, bool with_ideal) {
  const std::string names = fmt::format(R"({{"enum": ["{}"]}})", fmt::join(known_score_names(), R"(", ")"));
  const Measure* measure = nullptr;
  if (const auto name = keys(must("name"), Form{"name", names}, "the scored quantity")) {
    rule.name = name->string();
    measure = find_measure(rule.name);
    if (!measure) name->fail(fmt::format("one of {}", fmt::join(known_score_names(), ", ")));
    rule.best = measure->best;
  }
  rule.target = kNoDefault;
  keys("target", rule.target, {}, "target; default: the value of the ideal shape, or that of the quantity");
  keys(must("tolerance"), rule.tolerance, {1e-9}, "deviation from the target that costs half of the points");
  keys(must("weight"), rule.weight, {0}, "relative share of the 100 points");
  std::string best;
  keys("best", best, kBestNames,
       "side of the target on which values lose no points (`near`: none); default: that of the quantity");
  if (!best.empty()) rule.best = static_cast<Best>(std::ranges::find(kBestNames, best) - kBestNames.begin());
  rule.critical = keys.json() ? std::numeric_limits<double>::infinity() : kNoDefault;
  keys("critical", rule.critical, {0}, "a value that misses the target by more fails the session");
  keys("source", rule.source, "publication of target and tolerance");
  rule.asked = true;
  if (!measure || keys.json()->has("target")) return;
  const auto usual = default_target(rule.name);
  if (usual && (measure->of_hand || !with_ideal)) {
    rule.target = *usual;
  } else if (!with_ideal) {
    keys.json()->fail(fmt::format("{} without a target", rule.name), "a target: there is no ideal to take it from");
  }
}

/// Adds the default rules to those that `block` states, and completes their targets.
std::vector<ScoreRule> complete_rules(const Json& block, const StatedScore& stated, const ScoreInput& input) {
  const std::optional<ScoreInput> ideal = has_ideal(input) ? std::optional(as_the_ideal(input)) : std::nullopt;
  std::vector<ScoreRule> rules;
  if (stated.defaults) rules = default_rules(input);
  // If the target shape itself leaves caries or opens the pulp, its value becomes the rule's target, so that the
  // target shape gets the full score.
  for (ScoreRule& rule : rules) {
    const Measure& measure = *find_measure(rule.name);
    const auto value = measure.of_hand || !ideal ? std::nullopt : value_of(measure, *ideal);
    if (value)
      rule.target = rule.best == Best::kAtLeast ? std::min(rule.target, *value) : std::max(rule.target, *value);
  }
  for (std::size_t i = 0; i < stated.rules.size(); ++i) {
    ScoreRule rule = stated.rules[i];
    if (std::isnan(rule.target)) {
      const auto value = value_of(*find_measure(rule.name), as_the_ideal(input));
      if (!value && input.cavity_ideal) {
        block["rules"].items()[i].fail(fmt::format("{} without a target", rule.name),
                                       "a target: the ideal has nothing of this kind");
      }
      if (!value) continue;  // the target shape has no such measure
      rule.target = *value;
    }
    const auto same = std::ranges::find(rules, rule.name, &ScoreRule::name);
    if (same == rules.end()) {
      rules.push_back(std::move(rule));
    } else {
      *same = std::move(rule);
    }
  }
  return rules;
}

}  // namespace

void describe_score(Keys& keys, StatedScore& stated, bool with_ideal) {
  const auto rule = [&](Keys& of, ScoreRule& read) {
    describe_rule(of, read, with_ideal);
    if (of.json() && std::ranges::count(stated.rules, read.name, &ScoreRule::name) > 1)
      (*of.json())["name"].fail("each rule once");
  };
  keys("rules", stated.rules, rule, "the scored quantities; a rule replaces the default rule of the same name");
  keys("defaults", stated.defaults, "false: only the rules of this block apply");
  const auto pass = [&](Keys& of) {
    of(must("points"), stated.pass.points, {0, 100}, "points of 100");
    of(must("source"), stated.pass.source, "source");
  };
  keys("pass", pass, "pass mark; default: 75 (ADEX)");
}

std::vector<ScoreRule> rules_from(const Json& block, const ScoreInput& input) {
  StatedScore stated;
  read_keys(block, [&](Keys& keys) { describe_score(keys, stated, has_ideal(input)); });
  return complete_rules(block, stated, input);
}

std::vector<ScoreRule> task_rules(const Json& task, const ScoreInput& input) {
  StatedScore stated;
  Keys keys(task);
  describe_score(keys, stated, task.has("ideal") || has_ideal(input));
  return complete_rules(task, stated, input);
}

Score score(const ScoreInput& input, std::span<const ScoreRule> rules, const PassMark& pass) {
  Score total;
  total.completion = completion(input);
  total.pass = pass;
  double weights = 0;
  for (const ScoreRule& rule : rules) {
    const Measure* measure = find_measure(rule.name);
    if (!measure) continue;
    const auto value = value_of(*measure, input);
    // A measure without value is left out. But if the task asks for it and the cavity was measured, it gives no points.
    if (!value && !(rule.asked && input.cavity)) continue;
    ScoreItem item;
    item.name = rule.name;
    item.value = value.value_or(std::nan(""));
    item.unit = measure->unit;
    item.basis = measure->basis;
    item.target = rule.target;
    item.tolerance = rule.tolerance;
    item.weight = rule.weight;
    item.best = rule.best;
    item.source = rule.source;
    if (input.cavity && rule.name.starts_with("over_cut") && input.cavity->over.depth > 0) {
      item.place_W = input.cavity->over.p_W;
    }
    if (input.cavity && rule.name.starts_with("under_cut") && input.cavity->under.depth > 0) {
      item.place_W = input.cavity->under.p_W;
    }
    if (input.cavity && rule.name == "wall_thickness_mm") item.place_W = input.cavity->thinnest_W;
    if (input.cavity && rule.name == "pulp_distance_mm") item.place_W = input.cavity->nearest_pulp_W;
    // Points decrease as a hyperbola of the excess: a worse value always costs more.
    item.points = value ? 1.0 / (1.0 + excess(rule, *value) / rule.tolerance) : 0.0;
    item.critical = value && excess(rule, *value) > rule.critical;
    weights += rule.weight;
    total.items.push_back(std::move(item));
  }
  double sum = 0;
  for (ScoreItem& item : total.items) {
    item.full = weights > 0 ? 100 * item.weight / weights : 0;
    item.points *= item.full;
    sum += item.points;
  }
  total.full = weights > 0 ? 100 : 0;
  // Rounding may give a sum above 100.
  total.points = std::min(total.full, total.completion * sum);
  return total;
}

}  // namespace typodont::session
