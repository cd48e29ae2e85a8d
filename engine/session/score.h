// Scores: pure functions from measures to points, each with an explanation. A perfect result gets the full score. Every
// worse result gets a lower score.
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

/// Measures of the hand, computed from the ticks. The members have the order of the report.
struct HandMeasures {
  double time = 0;           // s, time from the first tick to the last
  double contact_time = 0;   // s, time with the head in contact with tissue
  double force_mean = 0;     // N, mean over the ticks in contact
  double force_max = 0;      // N
  double path_length = 0;    // m, path length of the head centre at the hand's pose, without tremor
  int strokes = 0;           // number of contacts in which tissue was cut
  double tremor_rms = 0;     // m, rms of the hand's motion above 5 Hz while in contact
  std::uint64_t faults = 0;  // number of ticks with any fault bit
};

/// Measures the hand. Pass ticks in order, in pieces of any size. The memory does not grow with the session's length.
class HandMeter {
 public:
  explicit HandMeter(double servo_rate);
  void add(std::span<const ServoTick> ticks);
  HandMeasures result() const;

 private:
  struct Filter {  // second-order high-pass filter for each axis
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
  // Path length: the sum of the distances between the mean positions of short intervals.
  std::uint64_t block_size_, block_count_ = 0;
  dvec3 block_sum_{0}, last_mean_{0};
  bool have_mean_ = false;
  double path_ = 0;
  // State for counting strokes.
  bool in_stroke_ = false;
  Nanos last_contact_ = 0;
  double stroke_cut_ = 0, removed_last_ = 0;
  int strokes_ = 0;
};

/// Damage that a rotating bur did to the surroundings of the working tooth.
struct DamageMeasures {
  bool neighbours = false, gum = false;         // true if the scene has neighbouring teeth; true if the scene has gum
  double neighbour_volume = 0, gum_volume = 0;  // m³, volume of neighbours and volume of gum that the bur entered
  double first = -1;                            // s, time of the first touch; negative: no touch
};

struct ScoreInput {
  PerTissue before{};              // m³
  PerTissue after{};               // m³
  std::optional<PerTissue> ideal;  // m³, volume of each tissue in the ideal result
  // 0..1, for each tissue the mean hardness of its removed part as a fraction of the tissue's own hardness; 0 if
  // nothing was removed. Absent for tissue of uniform hardness.
  std::optional<PerTissue> removed_hardness;
  HandMeasures hand;
  std::optional<double> pulp_distance;         // m, smallest distance of the cut surface from the pulp
  std::optional<CavityMeasures> cavity;        // geometry of the result, if it was measured
  std::optional<CavityMeasures> cavity_ideal;  // geometry of the ideal, which a perfect hand would achieve
  std::optional<ExploreMeasures> explore;      // set for an exploration task
  std::optional<DamageMeasures> damage;        // set if the scene has surroundings
  std::optional<ImplantMeasures> implant;      // set for an exercise in implant surgery
};

/// Source of the default pass mark (a key of the text catalogue).
inline constexpr std::string_view kDefaultPassSource =
    "75 of 100, as in the ADEX licensure examination in dentistry; Typodont's default, set it in the scene";

/// The side of the target on which a value loses points.
enum class Best { kAtMost, kAtLeast, kNear };

/// A rule of the score. A deviation of `tolerance` from the target halves the points; a deviation of twice the
/// tolerance leaves a third.
struct ScoreRule {
  std::string name;  // one of known_score_names()
  double target = 0;
  double tolerance = 1;
  // weight relative to the weights of the other rules; together the rules give 100 points; 0: shown but not counted
  double weight = 0;
  Best best = Best::kAtMost;
  std::string source;  // literature source of target and tolerance
  bool asked = false;  // the task names this rule: an absent measure (no floor …) then earns no points
};

struct ScoreItem {
  std::string name;
  double value = 0;  // NaN: not measured, no points
  std::string unit;
  std::optional<dvec3> place_W;  // m, position of the worst point of this item
  double target = 0, tolerance = 0, weight = 0;
  Best best = Best::kAtMost;
  std::string source;
  double points = 0;  // points of this item, 0 to full
  double full = 0;    // points for a perfect value: 100 · weight / sum of all weights
};

/// Points out of 100 that a session needs to pass.
struct PassMark {
  double points = 75;
  std::string source = std::string(kDefaultPassSource);
};

struct Score {
  std::vector<ScoreItem> items;
  double points = 0;  // points, 0 to full: the sum of the items' points, times the completed fraction of the task
  double full = 0;    // 100; 0 if no item counts
  // Completed fraction of the task, which scales the sum of the items' points. It is the fraction of the ideal's
  // changes, of the lesions found and the surface explored, or of the caries; otherwise 1 if any tissue was cut or
  // filled. So careful inactivity earns no points, while a perfect item still shows its full points.
  double completion = 1;
  PassMark pass;

  bool counts() const { return full > 0; }
  bool passed() const { return points >= pass.points; }
  /// True if the item's fraction of its full points is below the pass mark's fraction of 100 points.
  bool missed(const ScoreItem& item) const { return item.full > 0 && item.points < pass.points / 100 * item.full; }
};

std::vector<std::string> known_score_names();
std::string_view unit_of(std::string_view score_name);

/// Default target of a measure for which neither a rule nor an ideal exists; no value if there is no default.
std::optional<double> default_target(std::string_view score_name);

/// The rules for a scene without rules of its own.
std::vector<ScoreRule> default_rules(const ScoreInput& input);
/// Reads a scene's "score" block: {"rules": [{"name", "target", "tolerance", "weight", "best", "source"}…],
/// "defaults": true}. Rules replace the defaults of the same name; "defaults": false starts without defaults. A rule
/// without a target uses the ideal's own value. If the rule concerns the hand, or if there is no ideal, the rule uses
/// the default target. If the ideal itself would miss a default target, the ideal's value replaces that target.
/// Throws Error.
std::vector<ScoreRule> rules_from(const Json& block, const ScoreInput& input);
/// Reads the same keys from a "task", which may also have other keys.
std::vector<ScoreRule> task_rules(const Json& task, const ScoreInput& input);
/// Checks names, kinds and ranges; this requires no session. Throws Error.
void check_rules(const Json& block);
/// Reads the "pass" of a task or "score" block: {"points": 0 to 100, "source": "…"}. If "pass" is missing, returns
/// the default. Throws Error.
PassMark pass_mark(const Json& block);

/// Computes the score. Items with an unknown value (no ideal, no caries, no pulp distance) are omitted together with
/// their weight, unless the task requires them.
Score score(const ScoreInput& input, std::span<const ScoreRule> rules, const PassMark& pass = {});

}  // namespace typodont::session
