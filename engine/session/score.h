// Computes scores. The functions convert measures to points, and explain each item of the score. A perfect result gets
// the full score, and every worse result gets a lower score.
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

/// Measures of the hand, computed from the ticks. The members have the same order as in the report.
struct HandMeasures {
  double time = 0;           // s, time from the first tick to the last
  double contact_time = 0;   // s, time in which the head touched tissue
  double force_mean = 0;     // N, mean force over the ticks with contact
  double force_max = 0;      // N, largest force in the session
  double path_length = 0;    // m, length of the path on which the hand (not the proxy) moved the tool, without tremor
  int strokes = 0;           // number of strokes, which are contacts in which tissue was cut
  double tremor_rms = 0;     // m, root mean square of the hand's motion above 5 Hz while in contact
  std::uint64_t faults = 0;  // number of ticks with any fault bit
};

/// Computes the measures of the hand's motion and force for the score. Call add() with the ticks in order, in pieces of
/// any size. The memory does not grow with the session's length.
class HandMeter {
 public:
  explicit HandMeter(double servo_rate);
  void add(std::span<const ServoTick> ticks);
  HandMeasures result() const;

 private:
  struct Filter {  // a second-order high-pass filter for each of the three axes
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
  // The path length is the sum of the distances between the mean positions of short intervals.
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

/// Damage that a rotating bur did to tissue next to the tooth that is worked on.
struct DamageMeasures {
  bool neighbours = false, gum = false;  // true if the scene has neighbouring teeth; true if it has gum
  // m³, volumes of the neighbouring teeth and of the gum that the bur passed through
  double neighbour_volume = 0, gum_volume = 0;
  double first = -1;  // s, time of the first touch; negative if there was none
};

struct ScoreInput {
  PerTissue before{};              // m³ of each tissue at the start
  PerTissue after{};               // m³ of each tissue at the end
  std::optional<PerTissue> ideal;  // m³ of each tissue in the ideal result
  // For each tissue: mean hardness of the removed part as a fraction (0..1) of the tissue's own hardness; 0 if nothing
  // was removed. No value if the tissues have uniform hardness.
  std::optional<PerTissue> removed_hardness;
  HandMeasures hand;
  std::optional<double> pulp_distance;         // m, smallest distance of the cut surface from the pulp
  std::optional<CavityMeasures> cavity;        // geometry of the result; no value if it was not measured
  std::optional<CavityMeasures> cavity_ideal;  // geometry of the target shape (ideal), which a perfect hand achieves
  std::optional<ExploreMeasures> explore;      // exists only for an exploration task
  std::optional<DamageMeasures> damage;        // exists only if the scene has neighbouring teeth or gum
  std::optional<ImplantMeasures> implant;      // exists only for an exercise in implant surgery
};

/// Origin of the default pass mark, as a text for the user. It is also a key of the text catalogue.
inline constexpr std::string_view kDefaultPassSource =
    "75 of 100, as in the ADEX licensure examination in dentistry; Typodont's default, set it in the scene";

/// States on which side of the target a value loses points.
enum class Best { kAtMost, kAtLeast, kNear };

/// A rule of the score. If a value deviates from the target by `tolerance`, half of the points remain; if it deviates
/// by twice the tolerance, a third remains.
struct ScoreRule {
  std::string name;  // name of the measure, one of known_score_names()
  double target = 0;
  double tolerance = 1;
  // Weight of this rule relative to the other rules. All rules together give 100 points. If the weight is 0, the value
  // is shown but gives no points.
  double weight = 0;
  Best best = Best::kAtMost;
  std::string source;  // publication from which target and tolerance were taken
  // true if the scene file lists this rule. The rule then gives no points if the result does not have this measure (for
  // example, the depth of the floor if the cavity has no floor).
  bool asked = false;
};

struct ScoreItem {
  std::string name;
  double value = 0;  // value of the measure; NaN: it was not measured, and this line of the score gets no points
  std::string unit;
  // m, frame W, point at which this measure is worst; no value if the measure has no such point
  std::optional<dvec3> place_W;
  double target = 0, tolerance = 0, weight = 0;
  Best best = Best::kAtMost;
  std::string source;
  double points = 0;  // points of this line of the score, 0 to `full`
  double full = 0;    // points for a perfect value: 100 · weight / sum of all weights
};

/// Number of points (of 100) that a session needs to pass.
struct PassMark {
  double points = 75;
  std::string source = std::string(kDefaultPassSource);
};

struct Score {
  std::vector<ScoreItem> items;
  double points = 0;  // sum of the items' points, multiplied by `completion`
  double full = 0;    // largest possible number of points: 100, or 0 if no line of the score gives points
  // Completed fraction of the task. The sum of the items' points is multiplied by this fraction. So a session without
  // work has the score 0, although items without deviation show their full points. Depending on the task, it is the
  // fraction of lesions found and surface explored, of the phases of an implant exercise, of the planned changes
  // (ideal), or of the caries. In all other tasks it is 1 if any tissue was cut or filled.
  double completion = 1;
  PassMark pass;

  bool counts() const { return full > 0; }
  bool passed() const { return points >= pass.points; }
  /// Returns true if an item (a line of the score) gets a smaller fraction of its full points than the pass mark
  /// requires (pass mark / 100).
  bool missed(const ScoreItem& item) const { return item.full > 0 && item.points < pass.points / 100 * item.full; }
};

std::vector<std::string> known_score_names();
std::string_view unit_of(std::string_view score_name);

/// Returns the default target of a measure, used if neither a rule nor an ideal states one. No value if there is no
/// default.
std::optional<double> default_target(std::string_view score_name);

/// Returns the rules for a scene that states no rules.
std::vector<ScoreRule> default_rules(const ScoreInput& input);
/// Reads the block "score" of a scene: {"rules": [{"name", "target", "tolerance", "weight", "best", "source"}…],
/// "defaults": true}. A rule replaces the default rule with the same name. With "defaults": false there are no default
/// rules. If a rule states no target, the ideal's value is its target. If the rule concerns the hand, or if there is no
/// ideal, the default target is used. If the ideal itself would miss a default target, the ideal's value replaces that
/// target. Throws Error.
std::vector<ScoreRule> rules_from(const Json& block, const ScoreInput& input);
/// Reads the same keys as rules_from() from the block "task" of a scene, which may also have other keys.
std::vector<ScoreRule> task_rules(const Json& task, const ScoreInput& input);
/// Checks names, kinds and ranges of the rules. This needs no session. Throws Error.
void check_rules(const Json& block);
/// Reads "pass" of a block "task" or "score": {"points": 0 to 100, "source": "…"}. If "pass" is missing, returns the
/// default. Throws Error.
PassMark pass_mark(const Json& block);

/// Computes the score. If the value of an item's measure is unknown (no ideal, no caries, no pulp distance), the item
/// and its weight are omitted. But if the task asks for this measure and the result's geometry was measured, the item
/// remains and gets no points.
Score score(const ScoreInput& input, std::span<const ScoreRule> rules, const PassMark& pass = {});

}  // namespace typodont::session
