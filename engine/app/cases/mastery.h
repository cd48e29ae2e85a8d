// A trainee's mastery of each skill, estimated from the points of recorded sessions (docs/cases.md). A logit is
// ln(p / (1 − p)) of a fraction p of the points.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/app/cases/case.h"
#include "engine/session/task.h"

namespace typodont {

/// Parameters of the estimate. All except `goal` are in logits.
struct MasteryModel {
  double prior_sd = 0;    // deviation of the abilities of trainees without sessions; their mean is 0
  double noise_sd = 0;    // deviation of a session's logit
  double session_sd = 0;  // change of the ability between two sessions (learning)
  double day_sd = 0;      // change of the ability per square root of a day (learning elsewhere, forgetting)
  double span = 0;        // a case of difficulty 1 is harder than a case of difficulty 0 by this
  double goal = 0;        // fraction of the points that the next case should give

  /// Difficulty of an item in a case, 0 to 1, as a logit.
  double item_difficulty(double of_case) const { return span * (of_case - 0.5); }
};

struct Skill {
  std::string name;
  session::TaskText title;
  std::vector<std::string> items;  // items of the score
};

struct SkillTable {
  MasteryModel model;
  std::vector<Skill> skills;
};
/// Reads assets/cases/skills.json. Throws Error.
SkillTable skill_table();

/// Estimate of one ability.
struct Mastery {
  double ability = 0, variance = 0;  // mean and variance, logits
  int sessions = 0;                  // number of observed sessions
};
Mastery unknown_mastery(const MasteryModel& model);
/// Updates the estimate after a session: `share` of the points in a case of this difficulty, `days` after the previous
/// session.
void observe(const MasteryModel& model, Mastery& mastery, double difficulty, double share, double days);
/// Expected fraction of the points in a case of this difficulty.
double expected_share(const MasteryModel& model, const Mastery& mastery, double difficulty);
/// How early the trainee is warned before an error: 1 at half of the points expected at difficulty ½ (a new trainee) or
/// fewer, 0 at the model's goal or more, linear between.
double warning_level(const MasteryModel& model, const Mastery& mastery);
/// The difficulty, of all real numbers, at which the expected fraction is `share`.
double difficulty_for(const MasteryModel& model, const Mastery& mastery, double share);

/// A recorded and scored session.
struct PastSession {
  std::string family;                         // empty: no generated case
  std::uint64_t seed = 0;                     // seed of the case
  double difficulty = 0.5;                    // difficulty of the case; 0.5 if it is unknown
  std::optional<double> day;                  // time of the recording, days since 1970; empty: unknown
  std::vector<std::optional<double>> shares;  // fraction of the points for each skill of the table; empty: no items
};

/// Points of one item of a score.
struct ItemPoints {
  std::string name;
  double points = 0, full = 0;
};
/// The fraction of the points for each skill. `completion`: completed fraction of the task.
std::vector<std::optional<double>> shares_of(const SkillTable& table, std::span<const ItemPoints> items,
                                             double completion);

/// Estimates after sessions in order of time, one for each skill of the table.
std::vector<Mastery> mastery_after(const SkillTable& table, std::span<const PastSession> sessions);

}  // namespace typodont
