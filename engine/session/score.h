// Converts measures to points, and explains each item. A perfect result gets full points, a worse one fewer.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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

/// Before scoring, sets the time of each tick to its index divided by the servo rate.
/// A replay can check these times, but not the recorded times, which are its input.
void set_scored_times(std::span<ServoTick> ticks, double servo_rate);

/// Points or per cent as they are printed: tenths, rounded down, because rounding up could show a missed pass mark as
/// reached.
inline double printed_points(double points) {
  constexpr double kRoundingError = 1e-7;  // more than sums of points are off
  return std::floor(10 * points + kRoundingError) / 10;
}

/// Measures of the hand's motion, computed from the ticks, in the order of the report.
struct HandMeasures {
  double time = 0;          // s, from the first to the last tick
  double contact_time = 0;  // s, time in which the head touched tissue
  double force_mean = 0;    // N, mean force over the ticks with contact
  double force_max = 0;     // N, largest force in the session
  double path_length = 0;   // m, path of the hand, not the proxy; without tremor
  int strokes = 0;          // number of contacts that removed tissue
  double tremor_rms = 0;    // m, root mean square tremor of 8 to 12 Hz, in contact
};

/// Computes HandMeasures. Call add() with all ticks in order, in any number of calls. Memory does not grow with the
/// session.
class HandMeter {
 public:
  explicit HandMeter(double servo_rate);
  void add(std::span<const ServoTick> ticks);
  HandMeasures result() const;

 private:
  void end_stroke();

  double rate_;
  bool first_ = true;
  Nanos t_first_ = 0, t_last_ = 0;
  std::uint64_t ticks_ = 0, contact_ticks_ = 0;
  double force_sum_ = 0, force_max_ = 0;
  // Tremor: the last positions, and sums of the squared motion in the octaves around 5, 10 and 20 Hz.
  std::size_t lag_;  // ticks, half a period of 20 Hz
  std::vector<dvec3> recent_;
  std::array<double, 3> octaves_{};
  // Path length: sum of the distances between mean positions over short intervals.
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

/// Damage by a rotating bur to tissue beside the tooth.
struct DamageMeasures {
  bool neighbours = false, gum = false;  // true: the scene has neighbouring teeth, or gum
  // Volume of neighbouring teeth and of gum that the bur passed through, m³.
  double neighbour_volume = 0, gum_volume = 0;
  /// One touch of a neighbouring tooth or of the gum by the bur, without a pause.
  struct Touch {
    bool gum = false;
    std::uint64_t first = 0, last = 0, worst = 0;  // indices of ticks; worst: the tick that adds the most volume
    std::uint32_t tool = 0;
    double volume = 0;  // m³, volume of tissue that the bur passed through
    dvec3 p_W{0};       // m, frame W, point in the head at the worst tick
  };
  std::vector<Touch> touches;
};

/// Extreme temperatures of pulp and bone, °C.
struct HeatMeasures {
  static constexpr double kBody = 37;  // °C, temperature of the body
  bool pulp = false, bone = false;     // true: the tissue contains pulp; true: it contains bone
  double pulp_max = kBody, pulp_min = kBody;
  double bone_max = kBody;  // °C, highest temperature of bone 0.5 mm from the wall of the cut
  double bone_above = 0;    // s, longest uninterrupted time above 47 °C
  // Temperatures at the end of each second, °C.
  std::vector<float> pulp_curve, bone_curve;
};

struct ScoreInput {
  PerTissue before{};              // m³ of each tissue at the start
  PerTissue after{};               // m³ of each tissue at the end
  std::optional<PerTissue> ideal;  // m³ of each tissue in the target shape
  // Mean hardness of the removed part of each tissue, 0 to 1; 0: nothing removed. Empty: all tissues have uniform
  // hardness.
  std::optional<PerTissue> removed_hardness;
  HandMeasures hand;
  std::optional<double> pulp_distance;         // m, smallest distance of the cut surface from the pulp
  std::optional<CavityMeasures> cavity;        // measures of the result; empty: not measured
  std::optional<CavityMeasures> cavity_ideal;  // measures of the target shape, for comparison
  std::optional<ExploreMeasures> explore;      // exists only for an exploration task
  std::optional<DamageMeasures> damage;        // exists only for scenes with neighbouring teeth or gum
  std::optional<HeatMeasures> heat;            // exists only for scenes with the key "heat"
  std::optional<ImplantMeasures> implant;      // exists only for an exercise in implant surgery
};

/// Source of the default pass mark, as the user sees it; also a key of the text catalogue.
inline constexpr std::string_view kDefaultPassSource =
    "75 of 100, as in the ADEX licensure examination in dentistry; Typodont's default, set it in the scene";

/// On which side of the target a value loses points.
enum class Best { kAtMost, kAtLeast, kNear };

/// A value that is off the target by `tolerance` gets half of the points; a value off by 2 × `tolerance`, a third.
struct ScoreRule {
  std::string name;  // name of the measure, one of known_score_names()
  double target = 0;
  double tolerance = 1;
  // Relative weight; the weights of all items together give 100 points. 0: the item is shown but gives no points.
  double weight = 0;
  Best best = Best::kAtMost;
  std::string source;  // publication from which target and tolerance were taken
  // A value that misses the target by more is a critical error: the session does not pass, whatever its points (the
  // worst fault decides: Duggan, Int Dent SA 2009).
  double critical = std::numeric_limits<double>::infinity();
  // True: the scene lists the rule. Then a measure without value (for example a floor's depth) gives no points.
  bool asked = false;
};

/// The data from which a value is computed. They determine how well a replay can verify the value.
enum class Basis {
  kReplay,  // computed from tissue, forces and poses, which a replay checks
  kTicks,   // computed also from the number of ticks and the servo rate
  kHand     // computed from the recorded hand, which is a replay's input: only a signature protects it
};

struct ScoreItem {
  std::string name;
  Basis basis = Basis::kReplay;
  double value = 0;  // the measure's value in its unit; NaN: not measured, gives no points
  std::string unit;
  // Point where the result is worst, m, frame W. Empty: there is no such point.
  std::optional<dvec3> place_W;
  double target = 0, tolerance = 0, weight = 0;
  Best best = Best::kAtMost;
  std::string source;
  double points = 0;      // 0 to `full`
  double full = 0;        // largest possible points: 100 · weight / sum of all weights
  bool critical = false;  // true: a critical error (ScoreRule::critical)
};

/// Points, of 100, that a session needs to pass.
struct PassMark {
  double points = 75;
  std::string source = std::string(kDefaultPassSource);
};

struct Score {
  std::vector<ScoreItem> items;
  double points = 0;  // sum of the items' points, multiplied by `completion`
  double full = 0;    // largest possible points: 100; 0 if no item gives points
  // Completed fraction of the task, 0 to 1; a factor of `points`, so that a trainee who does nothing gets 0. The
  // fraction of lesions found and surface explored, finished phases, required changes made, or caries removed.
  double completion = 1;
  PassMark pass;

  bool counts() const { return full > 0; }
  bool failed_critically() const {
    return std::ranges::any_of(items, [](const ScoreItem& item) { return item.critical; });
  }
  bool passed() const { return points >= pass.points && !failed_critically(); }
  /// True if the item is a critical error, or got a smaller fraction of its points than the pass mark.
  bool missed(const ScoreItem& item) const {
    return item.critical || (item.full > 0 && item.points < pass.points / 100 * item.full);
  }
};

std::vector<std::string> known_score_names();
std::string_view unit_of(std::string_view score_name);

/// Default target of a measure, used if neither the rule nor the ideal shape has one. Empty: there is none.
std::optional<double> default_target(std::string_view score_name);

/// Default rules, for scenes that state none.
std::vector<ScoreRule> default_rules(const ScoreInput& input);

/// What the block "task" or "score" of a scene states about the score.
struct StatedScore {
  std::vector<ScoreRule> rules;  // a target that only the ideal shape gives is NaN
  bool defaults = true;          // true: default_rules() apply to the measures without a rule
  PassMark pass;
};
/// Declares the keys "rules", "defaults" and "pass". `with_ideal`: true if an ideal shape gives missing targets. Throws
/// Error.
void describe_score(Keys& keys, StatedScore& stated, bool with_ideal);

/// The rules of the block "score", and the default rules that none of them replaces. A missing target is the value of
/// the target shape, else the default. Throws Error.
std::vector<ScoreRule> rules_from(const Json& block, const ScoreInput& input);
/// Like rules_from(), but for the block "task", in which other keys are allowed.
std::vector<ScoreRule> task_rules(const Json& task, const ScoreInput& input);

/// Computes the score. An item without value is left out, and its weight does not count. But if the task lists the
/// item and the geometry was measured, its weight counts and it gives no points.
Score score(const ScoreInput& input, std::span<const ScoreRule> rules, const PassMark& pass = {});

}  // namespace typodont::session
