// Runs experiments with two-alternative trials. Each trial presents two stimuli one after the other in random order,
// and the subject says which was greater. The plan defines the trials. The subject is a person in a live session
// (live_subject.h) or a simulated observer (simulated_subject.h). For one thread only.
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
/// Returns the unit of the difference between stimuli: "%" or "ms"; empty for a comparison of models.
std::string_view unit_of(Question question);
/// Returns the question in words, for example "Which was stiffer?"
std::string_view words_of(Question question, session::Language language = session::Language::kEnglish);

/// One of the two stimuli of a trial. Each member replaces or scales a property of the scene.
struct Stimulus {
  std::string model;           // contact model of the stimulus; empty: the scene's contact model
  double stiffness_ratio = 1;  // stiffness of the stimulus, divided by the stiffness of the scene
  double force_fraction = 1;   // 0..1, factor by which the force on the hand is multiplied
  double delay = 0;            // s, delay of the force at the hand
};

struct Trial {
  int number = 0;  // number of the trial; the first trial is 1
  std::array<Stimulus, 2> stimuli;
  /// Value of each of the two stimuli, in the unit that the log states: N/mm, % or ms. If models are compared: index of
  /// each stimulus's model in ExperimentPlan::models.
  std::array<double, 2> values{};
  double level = 0;  // difference between the greater and the smaller stimulus, in the unit of the question
  /// true: the second stimulus is the greater one (for models: the second stimulus has the second model)
  bool greater_second = false;
};

enum class Answer { kFirst, kSecond };

struct AnsweredTrial {
  Trial trial;
  Answer answer = Answer::kFirst;
  double seconds = 0;  // s, time from the question to the answer; 0 for a simulated subject
  bool right() const { return (answer == Answer::kSecond) == trial.greater_second; }
};

struct ExperimentPlan {
  Question question = Question::kStiffness;
  double scene_stiffness = 0;  // N/m, stiffness of the scene's coupling (spring between hand and tool)
  double reference = 0;  // value of the reference stimulus; stiffness: N/mm; force: % of the servo's force; delay: ms
  std::array<std::string, 2> models;  // the two compared contact models; used only for Question::kModel
  StaircaseRule rule;                 // rule of the staircase; not used for Question::kModel
  int trials = 150;                   // largest number of trials; for a comparison of models, exactly this number
  // a reversal (turn) is a change between rising and falling levels; the experiment ends after this number of reversals
  int turns = 24;
  std::uint64_t seed = 1;  // random seed for the order of the stimuli
};

/// Provides the trials of a plan one by one and collects the answers.
class Experiment {
 public:
  explicit Experiment(const ExperimentPlan& plan);

  bool over() const;
  /// Returns how much of the experiment is completed, 0..1. This is the larger of two fractions: the fraction of the
  /// planned trials, and the fraction of the planned turns (reversals of the staircase).
  double fraction() const;
  /// Returns the present trial. It stays the same until answer() is called.
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
  // Only for a comparison of models, one value per trial: true if the second model is presented second. Both orders
  // occur equally often.
  std::vector<bool> orders_;
  Trial next_;
  std::vector<AnsweredTrial> answered_;
};

/// The result of an experiment, computed from its answered trials. The trials may come from a log.
struct ExperimentResult {
  Question question = Question::kStiffness;
  std::array<std::string, 2> models;
  int trials = 0, right = 0;
  std::optional<PsychometricFit> fit;  // fitted psychometric function; empty if models are compared
  int turns = 0;                       // number of turns (reversals) of the staircase
  // settled_level: difference at which the staircase settled; target: fraction of right answers at this difference
  double settled_level = 0, target = 0;
  Estimate chosen;  // fraction of the answers that chose the second model
  // p-value. If the answers are random, both models are chosen equally often on average. This is the probability that
  // random answers differ from this equal split by at least as much as the subject's answers do.
  double chance = 1;
  Estimate second;  // fraction of the trials in which the subject answered "second"
};

ExperimentResult result_of(const ExperimentPlan& plan, const std::vector<AnsweredTrial>& answered);

/// Returns the result as indented JSON. `log`: name of the file with the trials.
std::string json_of(const ExperimentResult& result, const std::string& log);
/// Returns the result as text for the terminal.
std::string words_of(const ExperimentResult& result);
/// Returns the result as a self-contained HTML page with plots of the staircase and of the fitted function.
std::string page_of(const ExperimentPlan& plan, const ExperimentResult& result,
                    const std::vector<AnsweredTrial>& answered, const std::string& title);

}  // namespace typodont
