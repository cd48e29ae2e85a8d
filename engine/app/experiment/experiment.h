// Two-alternative trials: two stimuli in random order, and the subject says which was greater. The subject is a person
// (live_subject.h) or simulated (simulated_subject.h). One thread only.
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
/// "%" or "ms"; empty for models.
std::string_view unit_of(Question question);
/// For example "Which was stiffer?"
std::string_view words_of(Question question, session::Language language = session::Language::kEnglish);

/// Each member replaces or scales a property of the scene.
struct Stimulus {
  std::string model;           // empty: the scene's contact model
  double stiffness_ratio = 1;  // relative to the scene's
  double force_fraction = 1;   // 0..1, of the force on the hand
  double delay = 0;            // s, delay of the force at the hand
};

struct Trial {
  int number = 0;  // from 1
  std::array<Stimulus, 2> stimuli;
  /// N/mm, % or ms, as in the log; models: index in ExperimentPlan::models.
  std::array<double, 2> values{};
  double level = 0;  // greater minus smaller, in the question's unit
  /// the second stimulus is the greater one, or has the second model
  bool greater_second = false;
};

enum class Answer { kFirst, kSecond };

struct AnsweredTrial {
  Trial trial;
  Answer answer = Answer::kFirst;
  double seconds = 0;  // from question to answer; 0 if simulated
  bool right() const { return (answer == Answer::kSecond) == trial.greater_second; }
};

struct ExperimentPlan {
  Question question = Question::kStiffness;
  double scene_stiffness = 0;         // N/m, of the scene's coupling
  double reference = 0;               // stiffness: N/mm; force: % of the servo's; delay: ms
  std::array<std::string, 2> models;  // only for kModel
  StaircaseRule rule;                 // rule of the staircase; not used for Question::kModel
  int trials = 150;                   // at most; for models: exactly
  // reversals of the staircase after which the experiment ends
  int turns = 24;
  std::uint64_t seed = 1;  // random seed for the order of the stimuli
};

/// Hands out the trials of a plan and collects the answers.
class Experiment {
 public:
  explicit Experiment(const ExperimentPlan& plan);

  bool over() const;
  /// 0..1, the larger of the fractions of trials and of reversals.
  double fraction() const;
  /// The same until answer().
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
  // For models: whether the second one comes second. Both orders equally often.
  std::vector<bool> orders_;
  Trial next_;
  std::vector<AnsweredTrial> answered_;
};

/// Computed from answered trials, which may come from a log.
struct ExperimentResult {
  Question question = Question::kStiffness;
  std::array<std::string, 2> models;
  int trials = 0, right = 0;
  std::optional<PsychometricFit> fit;  // fitted psychometric function; empty if models are compared
  int turns = 0;                       // number of turns (reversals) of the staircase
  // difference where the staircase settled; fraction right there
  double settled_level = 0, target = 0;
  Estimate chosen;  // fraction for the second model
  // p-value: probability that random answers differ from an equal split at least as much.
  double chance = 1;
  Estimate second;  // fraction of answers "second"
};

ExperimentResult result_of(const ExperimentPlan& plan, const std::vector<AnsweredTrial>& answered);

/// Indented JSON. `log`: the file of the trials.
std::string json_of(const ExperimentResult& result, const std::string& log);
/// For the terminal.
std::string words_of(const ExperimentResult& result);
/// A self-contained HTML page with plots.
std::string page_of(const ExperimentPlan& plan, const ExperimentResult& result,
                    const std::vector<AnsweredTrial>& answered, const std::string& title);

}  // namespace typodont
