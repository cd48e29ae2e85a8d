// Two-alternative trials: two stimuli one after the other in random order, and one question, "which was greater?". The
// plan says what each trial shows; a subject answers it: a person at a live session (live_subject.h) or a simulated
// observer (simulated_subject.h). One thread.
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

namespace typodont {

enum class Question { kStiffness, kForce, kDelay, kModel };
inline constexpr std::array<std::string_view, 4> kQuestionNames{"stiffness", "force", "delay", "model"};
std::string_view name_of(Question question);
/// "%" or "ms"; empty for models.
std::string_view unit_of(Question question);
/// "Which was stiffer?"
std::string_view words_of(Question question);

/// What the hand feels in one half of a trial, as a change of the scene.
struct Stimulus {
  std::string model;           // contact model; empty: the scene's
  double stiffness_share = 1;  // of the scene's stiffness
  double force_fraction = 1;   // 0..1, of the force that reaches the hand
  double delay = 0;            // s, of the force
};

struct Trial {
  int number = 0;  // from 1
  std::array<Stimulus, 2> stimuli;
  /// What the log holds of each: N/mm, %, ms; of models the place in ExperimentPlan::models.
  std::array<double, 2> values{};
  double level = 0;             // by how much the greater exceeds the reference, in the unit of the question
  bool greater_second = false;  // the greater one, or the second model, is shown second
};

enum class Answer { kFirst, kSecond };

struct AnsweredTrial {
  Trial trial;
  Answer answer = Answer::kFirst;
  double seconds = 0;  // that the subject thought; 0: a simulated one
  bool right() const { return (answer == Answer::kSecond) == trial.greater_second; }
};

struct ExperimentPlan {
  Question question = Question::kStiffness;
  double scene_stiffness = 0;         // N/m, of the scene's coupling
  double reference = 0;               // stiffness: N/mm; force: % of the servo's force; delay: ms
  std::array<std::string, 2> models;  // that are compared, where the question is about models
  StaircaseRule rule;                 // of all other questions
  int trials = 150;                   // at most; of models: exactly
  int turns = 24;                     // of the staircase, after which the experiment is over
  std::uint64_t seed = 1;             // of the order
};

/// Asks until the plan is done, or until the subject gives no answer: it left.
class Experiment {
 public:
  explicit Experiment(const ExperimentPlan& plan);

  bool over() const;
  /// The next trial. The same until answer().
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
  std::vector<bool> orders_;  // of models: as many trials with the second one second as first
  Trial next_;
  std::vector<AnsweredTrial> answered_;
};

/// What the answers say. Made from a plan and its trials, whether they were just given or read from a log.
struct ExperimentResult {
  Question question = Question::kStiffness;
  std::array<std::string, 2> models;
  int trials = 0, right = 0;
  std::optional<PsychometricFit> fit;    // of all questions but models
  int turns = 0;                         // of the staircase
  double settled_level = 0, target = 0;  // where the staircase settled, and at which share of right answers
  Estimate chosen;                       // share of the answers for the second model
  double chance = 1;                     // probability of such answers if nothing were felt
  Estimate second;                       // share of the answers "second"
};

ExperimentResult result_of(const ExperimentPlan& plan, const std::vector<AnsweredTrial>& answered);

/// JSON object, pretty-printed. `log`: name of the file with the trials.
std::string json_of(const ExperimentResult& result, const std::string& log);
/// In words, for the terminal.
std::string words_of(const ExperimentResult& result);
/// A self-contained page with the staircase and the fitted function.
std::string page_of(const ExperimentPlan& plan, const ExperimentResult& result,
                    const std::vector<AnsweredTrial>& answered, const std::string& title);

}  // namespace typodont
