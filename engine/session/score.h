// Scores: pure functions from what was measured to points, each explained. A perfect result scores full; every
// worsening lowers the score.
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

/// What the ticks say about the hand. Order of members as in the report.
struct HandMeasures {
  double time = 0;           // s, first tick to last
  double contact_time = 0;   // s with the head in tissue
  double force_mean = 0;     // N, over the ticks in contact
  double force_max = 0;      // N
  double path_length = 0;    // m, of the head centre as held, tremor averaged out
  int strokes = 0;           // times the head was put to the tissue and cut
  double tremor_rms = 0;     // m, hand path above 5 Hz while in contact
  std::uint64_t faults = 0;  // ticks with any fault bit
};

/// Feed ticks in order, in pieces of any size; memory does not grow with the session.
class HandMeter {
 public:
  explicit HandMeter(double servo_rate);
  void add(std::span<const ServoTick> ticks);
  HandMeasures result() const;

 private:
  struct Filter {  // one second-order high-pass section per axis
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
  // Path: means of short blocks, joined.
  std::uint64_t block_size_, block_count_ = 0;
  dvec3 block_sum_{0}, last_mean_{0};
  bool have_mean_ = false;
  double path_ = 0;
  // Strokes.
  bool in_stroke_ = false;
  Nanos last_contact_ = 0;
  double stroke_cut_ = 0, removed_last_ = 0;
  int strokes_ = 0;
};

/// What a turning bur did to what stands around the working tooth.
struct DamageMeasures {
  bool neighbours = false, gum = false;         // whether there are any
  double neighbour_volume = 0, gum_volume = 0;  // m³ that the bur was in
  double first = -1;                            // s, when it first touched; negative: it did not
};

struct ScoreInput {
  PerTissue before{};              // m³
  PerTissue after{};               // m³
  std::optional<PerTissue> ideal;  // m³ of the ideal result
  std::optional<PerTissue>
      removed_hardness;  // mean of what was removed of each tissue, 0..1 of its own hardness; 0
                         // where nothing was. Nothing in tissue whose hardness is the same all over
  HandMeasures hand;
  std::optional<double> pulp_distance;         // m, nearest of the cut surface to the pulp
  std::optional<CavityMeasures> cavity;        // the geometry of the result, where it was measured
  std::optional<CavityMeasures> cavity_ideal;  // and of the ideal: what a perfect hand would get
  std::optional<ExploreMeasures> explore;      // of a task that is to explore
  std::optional<DamageMeasures> damage;        // where the scene has surroundings
  std::optional<ImplantMeasures> implant;      // of an exercise in implant surgery
};

/// The pass mark where a scene names none, with its source (an entry of the catalogue of texts).
inline constexpr std::string_view kUsualPassSource =
    "75 of 100, as in the ADEX licensure examination in dentistry; Typodont's default, set it in the scene";

/// Which side of the target costs points.
enum class Best { kAtMost, kAtLeast, kNear };

/// `tolerance` beyond the target halves the points; twice that leaves a third.
struct ScoreRule {
  std::string name;  // one of known_score_names()
  double target = 0;
  double tolerance = 1;
  double weight = 0;  // its share of the hundred points, beside the other rules' weights; 0: shown, not counted
  Best best = Best::kAtMost;
  std::string source;  // where target and tolerance come from
  bool asked = false;  // named by the task: where there is nothing to measure (no floor …), it earns nothing
};

struct ScoreItem {
  std::string name;
  double value = 0;  // NaN: nothing there to measure, so no points
  std::string unit;
  std::optional<dvec3> place_W;  // m, where the worst of it is
  double target = 0, tolerance = 0, weight = 0;
  Best best = Best::kAtMost;
  std::string source;
  double points = 0;  // 0 .. full
  double full = 0;    // points for a perfect value: 100 · weight / sum of all weights
};

/// From how many of the hundred points on a session counts as passed.
struct PassMark {
  double points = 75;
  std::string source = std::string(kUsualPassSource);
};

struct Score {
  std::vector<ScoreItem> items;
  double points = 0;      // 0 .. full: the sum of the items' points, times the share of the task done
  double full = 0;        // 100; 0 where nothing counts
  double completion = 1;  // share of the task done (of what the ideal changes, of the lesions found and the surface
                          // explored, of the caries, else whether anything was cut or filled); scales the sum, so
                          // that doing nothing carefully earns nothing, and a perfect item shows its full points
  PassMark pass;

  bool counts() const { return full > 0; }
  bool passed() const { return points >= pass.points; }
  /// An item that earned a smaller share of its points than the pass mark is of the hundred.
  bool missed(const ScoreItem& item) const { return item.full > 0 && item.points < pass.points / 100 * item.full; }
};

std::vector<std::string> known_score_names();
std::string_view unit_of(std::string_view score_name);

/// A measure's target where neither rule nor ideal says one; nothing where there is no usual one.
std::optional<double> usual_target(std::string_view score_name);

/// The rules where a scene says nothing.
std::vector<ScoreRule> default_rules(const ScoreInput& input);
/// A scene's "score" block: {"rules": [{"name", "target", "tolerance", "weight", "best", "source"}…], "defaults":
/// true}. Rules replace the defaults of the same name; "defaults": false starts from none. A rule without a target
/// takes what the ideal itself has, one about the hand or without an ideal the default's. Defaults that the ideal
/// itself would miss take what it has. Throws Error.
std::vector<ScoreRule> rules_from(const Json& block, const ScoreInput& input);
/// The same of a "task", which holds other keys beside them.
std::vector<ScoreRule> task_rules(const Json& task, const ScoreInput& input);
/// The checks that need no session: names, kinds, ranges. Throws Error.
void check_rules(const Json& block);
/// The "pass" of a task or "score" block: {"points": 0 to 100, "source": "…"}; the usual one where there is none.
/// Throws Error.
PassMark pass_mark(const Json& block);

/// Items whose value cannot be known (no ideal, no caries, no pulp distance) are left out, and so is their weight;
/// unless the task asks for them.
Score score(const ScoreInput& input, std::span<const ScoreRule> rules, const PassMark& pass = {});

}  // namespace typodont::session
