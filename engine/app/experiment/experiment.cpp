#include "engine/app/experiment/experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/units.h"

namespace typodont {

namespace {

Stimulus stimulus_of(const ExperimentPlan& plan, double value) {
  Stimulus stimulus;
  switch (plan.question) {
    case Question::kStiffness:
      stimulus.stiffness_ratio = value * kNewtonPerMillimetre / plan.scene_stiffness;
      break;
    case Question::kForce:
      stimulus.force_fraction = value / 100;
      break;
    case Question::kDelay:
      stimulus.delay = value * 1e-3;
      break;
    case Question::kModel:
      stimulus.model = plan.models[static_cast<std::size_t>(value)];
      break;
  }
  return stimulus;
}

nlohmann::ordered_json number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

/// An estimate as text: "4.5 % (95 %: 2.4 to 8 %)". If the upper limit is infinite, only the lower limit.
std::string text_of(const Estimate& e, std::string_view unit) {
  if (!std::isfinite(e.high)) return fmt::format("not determined, {:.3g} {} or more", e.low, unit);
  return fmt::format("{:.3g} {} (95 %: {:.3g} to {:.3g} {})", e.value, unit, e.low, e.high, unit);
}

}  // namespace

std::string_view name_of(Question question) {
  return kQuestionNames[static_cast<std::size_t>(question)];
}
std::string_view unit_of(Question question) {
  return question == Question::kModel ? "" : question == Question::kDelay ? "ms" : "%";
}
std::string_view words_of(Question question, session::Language language) {
  return session::text(fmt::format("hud.which.{}", name_of(question)), language);
}

Experiment::Experiment(const ExperimentPlan& plan) : plan_(plan), staircase_(plan.rule), random_(plan.seed) {
  if (plan_.question == Question::kModel) {
    for (int i = 0; i < plan_.trials; ++i) orders_.push_back(i % 2 == 1);
    // std::shuffle would give other results with other standard libraries.
    for (std::size_t i = orders_.size(); i > 1; --i) {
      const std::size_t j = random_() % i;
      const bool moved = orders_[i - 1];
      orders_[i - 1] = orders_[j], orders_[j] = moved;
    }
  }
  prepare();
}

bool Experiment::over() const {
  if (static_cast<int>(answered_.size()) >= plan_.trials) return true;
  return plan_.question != Question::kModel && staircase_.turns() >= plan_.turns;
}

double Experiment::fraction() const {
  const double trials = static_cast<double>(answered_.size()) / plan_.trials;
  const double turns = plan_.question == Question::kModel ? 0 : static_cast<double>(staircase_.turns()) / plan_.turns;
  return std::clamp(std::max(trials, turns), 0.0, 1.0);
}

void Experiment::prepare() {
  if (over()) return;
  next_ = {};
  next_.number = static_cast<int>(answered_.size()) + 1;
  // Values of both stimuli; for kModel: indices of the models.
  double lesser = 0, greater = 1;
  if (plan_.question == Question::kModel) {
    next_.greater_second = orders_[answered_.size()];
  } else {
    next_.greater_second = (random_() & 1) != 0;
    next_.level = staircase_.level();
    lesser = plan_.reference;
    greater = plan_.question == Question::kDelay ? lesser + next_.level : lesser * (1 + next_.level / 100);
  }
  next_.values = next_.greater_second ? std::array{lesser, greater} : std::array{greater, lesser};
  for (std::size_t i = 0; i < 2; ++i) next_.stimuli[i] = stimulus_of(plan_, next_.values[i]);
}

void Experiment::answer(Answer answer, double seconds) {
  answered_.push_back({next_, answer, seconds});
  if (plan_.question != Question::kModel) staircase_.answer(answered_.back().right());
  prepare();
}

ExperimentResult result_of(const ExperimentPlan& plan, const std::vector<AnsweredTrial>& answered) {
  ExperimentResult result;
  result.question = plan.question, result.models = plan.models;
  result.trials = static_cast<int>(answered.size());
  std::vector<Judgement> judgements;
  Staircase staircase(plan.rule);
  int second = 0;
  for (const AnsweredTrial& a : answered) {
    const bool said_second = a.answer == Answer::kSecond;
    result.right += a.right();
    second += said_second;
    judgements.push_back({a.trial.greater_second ? a.trial.level : -a.trial.level, said_second});
    staircase.answer(a.right());
  }
  if (answered.empty()) return result;
  result.second = fraction_of(second, result.trials);
  if (plan.question == Question::kModel) {
    // When contact models are compared, `right` counts the answers that chose the second model.
    result.chosen = fraction_of(result.right, result.trials);
    result.chance = chance_of(result.right, result.trials);
    return result;
  }
  result.fit = fit_psychometric(judgements);
  result.turns = staircase.turns();
  result.settled_level = staircase.settled_level(), result.target = plan.rule.target();
  return result;
}

std::string json_of(const ExperimentResult& result, const std::string& log) {
  nlohmann::ordered_json json = {{"question", name_of(result.question)}, {"trials", result.trials}};
  if (result.fit) {
    const std::string unit = result.question == Question::kDelay ? "ms" : "percent";
    const PsychometricFit& fit = *result.fit;
    json["right_percent"] = 100.0 * result.right / result.trials;
    json["jnd_" + unit] = {
        {"value", number(fit.jnd.value)}, {"low", number(fit.jnd.low)}, {"high", number(fit.jnd.high)}};
    json["bias_" + unit] = {{"value", fit.bias.value}, {"low", fit.bias.low}, {"high", fit.bias.high}};
    json["lapse_percent"] = 100 * fit.function.lapse;
    json["log_likelihood"] = fit.log_likelihood;
    json["staircase"] = {{"turns", result.turns},
                         {"settles_at_percent_right", 100 * result.target},
                         {"level_" + unit, result.settled_level > 0 ? number(result.settled_level) : nullptr}};
  } else if (result.trials > 0) {
    json["models"] = {result.models[0], result.models[1]};
    json["chosen_percent"] = {{"model", result.models[1]},
                              {"value", 100 * result.chosen.value},
                              {"low", 100 * result.chosen.low},
                              {"high", 100 * result.chosen.high}};
    json["chance"] = result.chance;
  }
  if (result.trials > 0) {
    json["answered_second_percent"] = {
        {"value", 100 * result.second.value}, {"low", 100 * result.second.low}, {"high", 100 * result.second.high}};
  }
  json["log"] = log;
  return json.dump(2);
}

std::string words_of(const ExperimentResult& result) {
  if (result.trials == 0) return "no trial was answered";
  if (!result.fit) {
    return fmt::format(
        "{} trials: {:.0f} % chose {} over {} (95 %: {:.0f} to {:.0f} %); by chance with probability {:.2g}",
        result.trials, 100 * result.chosen.value, result.models[1], result.models[0], 100 * result.chosen.low,
        100 * result.chosen.high, result.chance);
  }
  const std::string_view unit = unit_of(result.question);
  const PsychometricFit& fit = *result.fit;
  std::string text = fmt::format("{} trials, {:.0f} % right\n", result.trials, 100.0 * result.right / result.trials);
  text += fmt::format("just-noticeable difference of {}: {}\n", name_of(result.question), text_of(fit.jnd, unit));
  text += fmt::format("bias by the order: {}, lapses: {:.0f} %", text_of(fit.bias, unit), 100 * fit.function.lapse);
  if (result.settled_level > 0)
    text += fmt::format("\nstaircase: settled at {:.3g} {}, where {:.0f} % of the answers are right",
                        result.settled_level, unit, 100 * result.target);
  return text;
}

}  // namespace typodont
