// Measures to points, each item explained. Perfect is full, worse is lower.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/json.h"
#include "engine/contract/contact.h"
#include "engine/contract/tissue.h"
#include "engine/session/cavity.h"
#include "engine/session/explore.h"
#include "engine/session/implant_measures.h"

namespace typodont::session {

/// Sets the times for a score: tick index / rate, which a replay checks. The recorded times are only its input.
void set_scored_times(std::span<ServoTick> ticks, double servo_rate);

/// From the ticks, in the report's order.
struct HandMeasures {
  double time = 0;           // s, first to last tick
  double contact_time = 0;   // s, time in which the head touched tissue
  double force_mean = 0;     // N, mean force over the ticks with contact
  double force_max = 0;      // N, largest force in the session
  double path_length = 0;    // m, of the hand (not the proxy), without tremor
  int strokes = 0;           // contacts that cut
  double tremor_rms = 0;     // m, root mean square above 5 Hz, in contact
  std::uint64_t faults = 0;  // number of ticks with any fault bit
};

/// add() in order, in any pieces. Memory does not grow with the session.
class HandMeter {
 public:
  explicit HandMeter(double servo_rate);
  void add(std::span<const ServoTick> ticks);
  HandMeasures result() const;

 private:
  struct Filter {  // second-order high-pass per axis
    dvec3 x1{0}, x2{0}, y1{0}, y2{0};
  };
  void end_stroke();

  double rate_;
  double b0_, a1_, a2_;
  Filter filter_;
  bool first_ = true;
  Nanos t_first_ = 0, t_last_ = 0;
  std::uint64_t ticks_ = 0, contact_ticks_ = 0, faults_ = 0, tremor_ticks_ = 0;
  double force_sum_ = 0, force_max_ = 0, tremor_square_ = 0;
  // Path: between mean positions of short intervals.
  std::uint64_t block_size_, block_count_ = 0;
  dvec3 block_sum_{0}, last_mean_{0};
  bool have_mean_ = false;
  double path_ = 0;
  // State for counting the strokes.
  bool in_stroke_ = false;
  Nanos last_contact_ = 0;
  double stroke_cut_ = 0, removed_last_ = 0;
  int strokes_ = 0;
};

/// By a rotating bur, beside the tooth.
struct DamageMeasures {
  bool neighbours = false, gum = false;  // the scene has such
  // m³ that the bur passed through
  double neighbour_volume = 0, gum_volume = 0;
  /// Without a pause.
  struct Touch {
    bool gum = false;
    std::uint64_t first = 0, last = 0, worst = 0;  // ticks; worst: most new volume
    std::uint32_t tool = 0;
    double volume = 0;  // m³
    dvec3 p_W{0};       // m, in the head at the worst tick
  };
  std::vector<Touch> touches;
};

/// Temperatures of the pulp's and the bone's hottest and coldest places, °C.
struct HeatMeasures {
  bool pulp = false, bone = false;  // the tissue has such
  double pulp_max = 37, pulp_min = 37;
  double bone_max = 37;   // 0.5 mm from the wall
  double bone_above = 0;  // s, longest time above 47 °C
  // at the end of each second
  std::vector<float> pulp_curve, bone_curve;
};

struct ScoreInput {
  PerTissue before{};              // m³ of each tissue at the start
  PerTissue after{};               // m³ of each tissue at the end
  std::optional<PerTissue> ideal;  // m³ of each tissue in the ideal result
  // Mean of the removed part, 0..1 of the tissue's own; 0: nothing removed. Empty: uniform hardness.
  std::optional<PerTissue> removed_hardness;
  HandMeasures hand;
  std::optional<double> pulp_distance;         // m, from the cut surface
  std::optional<CavityMeasures> cavity;        // empty: not measured
  std::optional<CavityMeasures> cavity_ideal;  // of the ideal
  std::optional<ExploreMeasures> explore;      // exists only for an exploration task
  std::optional<DamageMeasures> damage;        // with neighbouring teeth or gum only
  std::optional<HeatMeasures> heat;            // with "heat" in the scene only
  std::optional<ImplantMeasures> implant;      // exists only for an exercise in implant surgery
};

/// For the user; also a key of the catalogue.
inline constexpr std::string_view kDefaultPassSource =
    "75 of 100, as in the ADEX licensure examination in dentistry; Typodont's default, set it in the scene";

/// Side of the target that loses points.
enum class Best { kAtMost, kAtLeast, kNear };

/// Off by `tolerance`: half the points; by twice that: a third.
struct ScoreRule {
  std::string name;  // name of the measure, one of known_score_names()
  double target = 0;
  double tolerance = 1;
  // Relative; all give 100. 0: shown only.
  double weight = 0;
  Best best = Best::kAtMost;
  std::string source;  // publication from which target and tolerance were taken
  // The scene lists it: without the measure (such as a floor's depth), no points.
  bool asked = false;
};

/// States what a value is computed from, and so what guarantees it.
enum class Basis {
  kReplay,  // tissue, forces, poses
  kTicks,   // these, number of ticks and servo rate
  kHand     // the recorded hand, input of a replay: only a signature protects it
};

struct ScoreItem {
  std::string name;
  Basis basis = Basis::kReplay;
  double value = 0;  // NaN: not measured, no points
  std::string unit;
  // m, W, where it is worst; empty: no such point
  std::optional<dvec3> place_W;
  double target = 0, tolerance = 0, weight = 0;
  Best best = Best::kAtMost;
  std::string source;
  double points = 0;  // 0 to `full`
  double full = 0;    // 100 · weight / all weights
};

/// Points, of 100, that a session needs to pass.
struct PassMark {
  double points = 75;
  std::string source = std::string(kDefaultPassSource);
};

struct Score {
  std::vector<ScoreItem> items;
  double points = 0;  // sum of the items' points, multiplied by `completion`
  double full = 0;    // 100, or 0 if nothing gives points
  // 0..1, multiplies the sum, so that no work scores 0: lesions found and surface explored, phases, planned changes, or
  // caries; otherwise 1 once anything was cut or filled.
  double completion = 1;
  PassMark pass;

  bool counts() const { return full > 0; }
  bool passed() const { return points >= pass.points; }
  /// Less of its full points than the pass mark.
  bool missed(const ScoreItem& item) const { return item.full > 0 && item.points < pass.points / 100 * item.full; }
};

std::vector<std::string> known_score_names();
std::string_view unit_of(std::string_view score_name);

/// Where neither rule nor ideal has one; empty: none.
std::optional<double> default_target(std::string_view score_name);

/// For scenes without rules.
std::vector<ScoreRule> default_rules(const ScoreInput& input);
/// {"rules": [{"name", "target", "tolerance", "weight", "best", "source"}…], "defaults": true}. A rule replaces the
/// default of its name; "defaults": false: no defaults. Target: stated, else the ideal's, else (hand, no ideal) the
/// default; an ideal that would miss a default replaces it. Throws Error.
std::vector<ScoreRule> rules_from(const Json& block, const ScoreInput& input);
/// The same keys in "task", beside others.
std::vector<ScoreRule> task_rules(const Json& task, const ScoreInput& input);
/// Names, kinds and ranges. Throws Error.
void check_rules(const Json& block);
/// "pass" of "task" or "score": {"points": 0 to 100, "source": "…"}, or the default. Throws Error.
PassMark pass_mark(const Json& block);

/// Items without value and their weight are left out, unless the task asks for them and the geometry was measured: no
/// points.
Score score(const ScoreInput& input, std::span<const ScoreRule> rules, const PassMark& pass = {});

}  // namespace typodont::session
