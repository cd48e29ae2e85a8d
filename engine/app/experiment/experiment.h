// Two-alternative trials: the subject feels two stimuli in random order, and states which was greater. The subject is a
// person (live_subject.h) or simulated (simulated_subject.h). One thread only.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "engine/app/experiment/psychometric.h"
#include "engine/app/experiment/staircase.h"
#include "engine/session/strings.h"

namespace typodont {

enum class Question { kStiffness, kForce, kDelay, kModel };
inline constexpr std::array<std::string_view, 4> kQuestionNames{"stiffness", "force", "delay", "model"};
std::string_view name_of(Question question);
/// Unit of differences between stimuli: "%" or "ms"; empty for models.
std::string_view unit_of(Question question);
/// The question as text, for example "Which was stiffer?".
std::string_view words_of(Question question, session::Language language = session::Language::kEnglish);

/// One stimulus. Each member replaces or scales a scene property.
struct Stimulus {
  std::string model;           // empty: the scene's contact model
  double stiffness_ratio = 1;  // factor on the scene's stiffness
  double force_fraction = 1;   // 0 to 1, fraction of the force that is felt
  double delay = 0;            // s, delay of the force at the hand
};

struct Trial {
  int number = 0;  // number of the trial, from 1
  std::array<Stimulus, 2> stimuli;
  /// Values of the stimuli in N/mm, % or ms, as in the log. For models: indices in ExperimentPlan::models.
  std::array<double, 2> values{};
  double level = 0;  // larger value minus smaller value, in the question's unit
  /// True: the second stimulus is the greater one, or has the second model.
  bool greater_second = false;
};

enum class Answer { kFirst, kSecond };

struct AnsweredTrial {
  Trial trial;
  Answer answer = Answer::kFirst;
  double seconds = 0;  // s, from the question to the answer; 0 if simulated
  bool right() const { return (answer == Answer::kSecond) == trial.greater_second; }
};

struct ExperimentPlan {
  Question question = Question::kStiffness;
  double scene_stiffness = 0;         // N/m, stiffness of the scene's coupling
  double reference = 0;               // reference stimulus; stiffness: N/mm; force: % of servo force; delay: ms
  std::array<std::string, 2> models;  // only for kModel
  StaircaseRule rule;                 // rule of the staircase; not used for Question::kModel
  int trials = 150;                   // largest number of trials; for Question::kModel: exact number
  // Number of staircase reversals after which the experiment ends.
  int turns = 24;
  std::uint64_t seed = 1;  // random seed for the order of the stimuli
};

/// Supplies the trials of a plan and collects the answers.
class Experiment {
 public:
  explicit Experiment(const ExperimentPlan& plan);

  bool over() const;
  /// Progress, 0 to 1. The larger of two fractions: trials made, and reversals made.
  double fraction() const;
  /// The current trial. Changes with each call of answer().
  const Trial& trial() const { return next_; }
  void answer(Answer answer, double seconds);

  const ExperimentPlan& plan() const { return plan_; }
  const std::vector<AnsweredTrial>& answered() const { return answered_; }
  const Staircase& staircase() const { return staircase_; }

 private:
  void prepare();

  ExperimentPlan plan_;
  Staircase staircase_;
  std::mt19937_64 random_;
  // If models are compared, for each trial: true if the second model comes second. Both orders occur equally often.
  std::vector<bool> orders_;
  Trial next_;
  std::vector<AnsweredTrial> answered_;
};

/// Result computed from answered trials, for example from a log.
struct ExperimentResult {
  Question question = Question::kStiffness;
  std::array<std::string, 2> models;
  int trials = 0, right = 0;
  std::optional<PsychometricFit> fit;  // fitted psychometric function; empty if models are compared
  int turns = 0;                       // number of reversals of the staircase
  // settled_level: difference between the stimuli where the staircase settled; target: fraction of right answers there.
  double settled_level = 0, target = 0;
  Estimate chosen;  // fraction of answers that chose the second model
  // p-value: probability that random answers deviate from an equal split at least as much.
  double chance = 1;
  Estimate second;  // fraction of answers that chose the second stimulus
};

ExperimentResult result_of(const ExperimentPlan& plan, const std::vector<AnsweredTrial>& answered);

/// The result as indented JSON. `log`: file of the trials.
std::string json_of(const ExperimentResult& result, const std::string& log);
/// The result as text for the terminal.
std::string words_of(const ExperimentResult& result);
/// The result as a self-contained HTML page with plots.
std::string page_of(const ExperimentPlan& plan, const ExperimentResult& result,
                    const std::vector<AnsweredTrial>& answered, const std::string& title);

}  // namespace typodont
